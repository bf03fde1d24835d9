#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "hil/montecarlo/campaign_folder.hpp"

namespace relnav::hil {

/// What the last step of a campaign did.
struct CampaignMerge {
  std::uint64_t results = 0;
  std::uint64_t missing = 0;
  std::optional<std::uint64_t> first_missing;
  std::uint64_t failures = 0;
  std::uint64_t errors = 0;
};

/// Reduces all results in the order of the runs to `summary.json`, `report.html` and `failures.csv` in the campaign's folder, and
/// packs complete thousands. The bytes follow from the results alone, not from when, where and in which order they were made.
/// Memory: 8 bytes a run and figure. Throws InputError.
CampaignMerge merge_campaign(const CampaignFolder& folder);

/// The command that does a run again, with all its files.
[[nodiscard]] std::string reproducing_command(const std::string& scenario, std::uint64_t run);

}  // namespace relnav::hil
