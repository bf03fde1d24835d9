#include "hil/montecarlo/campaign_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>

#include "hil/io/atomic_file.hpp"
#include "hil/io/fast_crc32.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

void make_campaign_folder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(folder, 0, "cannot be created: " + error.message(), "a writable output folder");
}

bool is_unfinished(const fs::path& path) { return path.filename().string().starts_with(unfinished_prefix); }

// Leftovers of whoever was killed while it began do not count.
bool is_as_good_as_empty(const std::string& folder) {
  std::error_code error;
  fs::directory_iterator entries(folder, error);
  if (error) throw InputError(folder, 0, "cannot be read: " + error.message(), "a writable output folder");
  return std::all_of(fs::begin(entries), fs::end(entries),
                     [](const auto& entry) { return is_unfinished(entry.path()); });
}

// Line k is of the thousand's run k; what is none is sorted out by parse_run_result().
std::vector<std::string_view> packed_lines(std::string_view text) {
  std::vector<std::string_view> lines;
  lines.reserve(runs_in_a_pack);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

}  // namespace

CampaignIdentity campaign_identity(const std::string& scenario, std::uint64_t runs, const std::string& version) {
  const std::string text = read_text(scenario);
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  return {fs::absolute(scenario).lexically_normal().string(), format_text("%08x", fast_crc32(bytes)), version, runs};
}

CampaignFolder::CampaignFolder(std::string folder, const CampaignIdentity& wanted, CampaignUse use)
    : folder_(std::move(folder)), identity_(wanted) {
  if (fs::exists(folder_) && !fs::is_directory(folder_))
    throw InputError(folder_, 0, "is a file", "a folder for the campaign");
  make_campaign_folder(folder_);
  lock(use);
  const auto stored = stored_identity();
  if (!stored) {
    if (!is_as_good_as_empty(folder_))
      throw InputError(folder_, 0, "is not empty and holds no campaign",
                       "a new or empty folder, or one of this campaign");
    store_identity();
    return;
  }
  const auto refuse = [&](const std::string& other, const std::string& ours) {
    throw InputError(folder_, 0, "holds another campaign, " + other, ours + ", or another folder");
  };
  if (stored->scenario_crc != wanted.scenario_crc) {
    refuse("of " + stored->scenario + " with CRC " + stored->scenario_crc,
           "that of " + wanted.scenario + " with CRC " + wanted.scenario_crc);
  }
  if (stored->version != wanted.version) refuse("made by version " + stored->version, "version " + wanted.version);
  if (stored->runs > wanted.runs) {
    throw InputError(folder_, 0, "holds a campaign of " + std::to_string(stored->runs) + " runs",
                     "as many --runs, or more to extend it");
  }
  identity_ = *stored;
  if (stored->runs < wanted.runs) {
    identity_.runs = wanted.runs;
    store_identity();
  }
}

CampaignFolder::CampaignFolder(std::string folder, CampaignUse use) : folder_(std::move(folder)) {
  if (!fs::exists(path("campaign.json")))
    throw InputError(folder_, 0, "holds no campaign", "a folder of relnav montecarlo");
  lock(use);
  const auto stored = stored_identity();
  if (!stored) throw InputError(folder_, 0, "holds no campaign", "a folder of relnav montecarlo");
  identity_ = *stored;
}

// On the folder itself: the system lets go of it however the process ends. A file system without locks goes without.
void CampaignFolder::lock(CampaignUse use) {
  FileHandle directory(::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!directory.is_open())
    throw InputError(folder_, 0, std::string("cannot be opened: ") + std::strerror(errno), "a writable output folder");
  // A campaign that was killed takes its runs along, but not in the same instant, and a run that has just been forked holds the lock.
  const int kind = (use == CampaignUse::alone ? LOCK_EX : LOCK_SH) | LOCK_NB;
  constexpr int attempts = 100;
  constexpr useconds_t pause_us = 20'000;
  bool taken = false;
  for (int i = 0; i < attempts && !taken; ++i) {
    taken = ::flock(directory.get(), kind) == 0 || errno != EWOULDBLOCK;
    if (!taken) ::usleep(pause_us);
  }
  if (!taken) throw InputError(folder_, 0, "is in use by another relnav montecarlo", "that it has ended");
  lock_.emplace(std::move(directory));
  if (use != CampaignUse::alone) return;
  std::error_code ignored;
  for (const auto& where : {folder_, path("runs")}) {
    for (const auto& entry : fs::directory_iterator(where, ignored)) {
      if (is_unfinished(entry.path())) fs::remove(entry.path(), ignored);
    }
  }
}

std::optional<CampaignIdentity> CampaignFolder::stored_identity() const {
  const auto text = text_if_there(path("campaign.json"));
  if (!text) return std::nullopt;
  const Json json = Json::parse(*text, nullptr, false);
  try {
    CampaignIdentity identity{json.at("scenario").get<std::string>(), json.at("scenario_crc").get<std::string>(),
                              json.at("version").get<std::string>(), json.at("runs").get<std::uint64_t>()};
    if (identity.runs >= 1 && identity.runs <= most_runs) return identity;
  } catch (const Json::exception&) {
  }
  throw InputError(path("campaign.json"), 0, "is damaged", "what relnav montecarlo wrote");
}

void CampaignFolder::store_identity() const {
  const Json json = {{"scenario", identity_.scenario},
                     {"scenario_crc", identity_.scenario_crc},
                     {"version", identity_.version},
                     {"runs", identity_.runs}};
  write_atomically(path("campaign.json"), json.dump(2) + "\n");
}

std::string CampaignFolder::single_folder(std::uint64_t thousand) const {
  return folder_ + "/runs/" + std::to_string(thousand);
}

std::string CampaignFolder::packed_path(std::uint64_t thousand) const { return single_folder(thousand) + ".jsonl"; }

std::string CampaignFolder::result_path(std::uint64_t run) const {
  return single_folder(run / runs_in_a_pack) + "/" + std::to_string(run) + ".json";
}

std::string CampaignFolder::part_path(std::uint64_t run) const {
  return single_folder(run / runs_in_a_pack) + "/" + std::to_string(run) + ".part";
}

bool CampaignFolder::has_single_files(std::uint64_t thousand) const {
  std::error_code error;
  return fs::is_directory(single_folder(thousand), error);
}

void CampaignFolder::visit_thousand(
    std::uint64_t thousand, std::uint64_t first, std::uint64_t end,
    const std::function<void(std::uint64_t, std::string_view, const RunResult*)>& visit) const {
  const std::uint64_t start = thousand * runs_in_a_pack;
  const std::string packed = text_if_there(packed_path(thousand)).value_or("");
  const std::vector<std::string_view> lines = packed_lines(packed);
  const bool singles = has_single_files(thousand);
  for (std::uint64_t run = first; run < end; ++run) {
    // A single file beside the packed one is the newer: the line was damaged, or the run was done again.
    if (singles) {
      if (const auto text = text_if_there(result_path(run))) {
        if (const auto result = parse_run_result(*text, run)) {
          visit(run, *text, &*result);
          continue;
        }
      }
    }
    const std::uint64_t index = run - start;
    const std::string_view line = index < lines.size() ? lines[index] : std::string_view();
    const auto result = line.empty() ? std::nullopt : parse_run_result(line, run);
    visit(run, line, result ? &*result : nullptr);
  }
}

void CampaignFolder::visit_results(std::uint64_t first, std::uint64_t count,
                                   const std::function<void(std::uint64_t, const RunResult*)>& visit) const {
  const std::uint64_t end = first + count;
  while (first < end) {
    const std::uint64_t thousand = first / runs_in_a_pack;
    const std::uint64_t here = std::min(end, (thousand + 1) * runs_in_a_pack);
    visit_thousand(thousand, first, here,
                   [&](std::uint64_t run, std::string_view, const RunResult* result) { visit(run, result); });
    first = here;
  }
}

void CampaignFolder::prepare(std::uint64_t run) const {
  make_campaign_folder(single_folder(run / runs_in_a_pack));
  ::unlink(part_path(run).c_str());
}

std::optional<RunResult> CampaignFolder::accept(std::uint64_t run) const {
  const std::string part = part_path(run);
  const auto text = text_if_there(part);
  auto result = text ? parse_run_result(*text, run) : std::nullopt;
  if (!result) {
    ::unlink(part.c_str());
  } else if (std::rename(part.c_str(), result_path(run).c_str()) != 0) {
    throw InputError(result_path(run), 0, std::string("cannot be written: ") + std::strerror(errno),
                     "room and permission to write");
  }
  return result;
}

void CampaignFolder::keep_error(const RunResult& result, double wall_s) const {
  write_atomically(result_path(result.run), error_result_json(result, wall_s));
  ::unlink(part_path(result.run).c_str());
}

bool CampaignFolder::pack(std::uint64_t thousand) const {
  if (!has_single_files(thousand)) return true;
  const std::uint64_t start = thousand * runs_in_a_pack;
  if (start + runs_in_a_pack > identity_.runs) return false;  // the last ones of a campaign that may still grow
  std::string packed;
  bool complete = true;
  visit_thousand(thousand, start, start + runs_in_a_pack,
                 [&](std::uint64_t, std::string_view text, const RunResult* result) {
                   complete = complete && result != nullptr;
                   if (complete) packed += one_line_json(text).value_or("") + "\n";
                 });
  if (!complete) return false;
  write_atomically(packed_path(thousand), packed);
  std::error_code error;
  fs::remove_all(single_folder(thousand), error);
  if (error)
    throw InputError(single_folder(thousand), 0, "cannot be removed: " + error.message(), "a writable output folder");
  return true;
}

}  // namespace relnav::hil
