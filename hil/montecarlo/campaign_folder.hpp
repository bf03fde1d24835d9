#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hil/io/file_handle.hpp"
#include "hil/montecarlo/run_result.hpp"

namespace relnav::hil {

/// What makes two campaigns the same one: the scenario's content and the program's version. The number of runs may grow.
struct CampaignIdentity {
  std::string scenario;      ///< absolute path
  std::string scenario_crc;  ///< 8 hex digits, of the bytes of that file
  std::string version;
  std::uint64_t runs = 0;
};

/// Of a scenario file as it is now; throws InputError when it cannot be read.
[[nodiscard]] CampaignIdentity campaign_identity(const std::string& scenario, std::uint64_t runs,
                                                 const std::string& version);

enum class CampaignUse : std::uint8_t {
  alone,          ///< refused while others work in the folder
  beside_others,  ///< for slices of an array job
};

inline constexpr std::uint64_t runs_in_a_pack = 1000;
inline constexpr std::uint64_t most_runs = 100'000'000;

/// The folder of a campaign: `campaign.json`, and the results, `runs/<thousand>/<run>.json`, of a finished thousand
/// `runs/<thousand>.jsonl`. A result is there under its name as a whole or not at all. All members throw InputError.
class CampaignFolder {
 public:
  /// Begins a campaign in a new or empty folder, goes on with the same one, or extends it to more runs. Refuses another one.
  CampaignFolder(std::string folder, const CampaignIdentity& wanted, CampaignUse use);
  /// Of a campaign that was begun before.
  CampaignFolder(std::string folder, CampaignUse use);

  [[nodiscard]] const CampaignIdentity& identity() const { return identity_; }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  [[nodiscard]] std::string result_path(std::uint64_t run) const;
  /// Where a run's process writes: no result yet.
  [[nodiscard]] std::string part_path(std::uint64_t run) const;

  /// Calls `visit` for each run from `first` on, in order, with its result or nullptr. Memory: one thousand at a time.
  void visit_results(std::uint64_t first, std::uint64_t count,
                     const std::function<void(std::uint64_t, const RunResult*)>& visit) const;
  /// Makes room for a run's files.
  void prepare(std::uint64_t run) const;
  /// Looks at what the run's process left: from now on it is the result, or nothing and it is gone.
  [[nodiscard]] std::optional<RunResult> accept(std::uint64_t run) const;
  /// The result of a run without one.
  void keep_error(const RunResult& result, double wall_s) const;

  /// Single files of this thousand are there.
  [[nodiscard]] bool has_single_files(std::uint64_t thousand) const;
  /// Puts the results of a complete thousand into one file and removes the single ones. Does nothing when one is missing; may
  /// be killed at any point and be called again.
  bool pack(std::uint64_t thousand) const;

 private:
  [[nodiscard]] std::string packed_path(std::uint64_t thousand) const;
  [[nodiscard]] std::string single_folder(std::uint64_t thousand) const;
  void lock(CampaignUse use);
  [[nodiscard]] std::optional<CampaignIdentity> stored_identity() const;
  void store_identity() const;
  void visit_thousand(std::uint64_t thousand, std::uint64_t first, std::uint64_t end,
                      const std::function<void(std::uint64_t, std::string_view, const RunResult*)>& visit) const;

  std::string folder_;
  std::optional<FileHandle> lock_;
  CampaignIdentity identity_;
};

}  // namespace relnav::hil
