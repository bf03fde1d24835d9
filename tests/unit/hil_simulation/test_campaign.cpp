// The runs of a campaign as processes, its folder, and what survives whom.
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "hil/io/atomic_file.hpp"
#include "hil/montecarlo/campaign.hpp"
#include "hil/montecarlo/campaign_summary.hpp"
#include "hil/simulation/scenario_file.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::message_of;
using relnav::test::Scratch;

namespace fs = std::filesystem;

namespace {

constexpr auto go_on_always = [](const CampaignProgress&) { return true; };
const char* const reduced_files[] = {"summary.json", "report.html", "failures.csv"};

}  // namespace

TEST_GROUP(Campaign) {
  Scratch scratch;
  std::string scenario = scratch.write("spin.yaml", "name: spin\n");

  void scenario_with(const std::string& lines) { scratch.write("spin.yaml", "name: spin\n" + lines); }
  CampaignIdentity identity(std::uint64_t runs) { return campaign_identity(scenario, runs, "0.1.0"); }
  static CampaignPlan plan(unsigned jobs) {
    CampaignPlan p;
    p.program = std::string(RELNAV_SOURCE_DIR) + "/tests/support/sim_stand_in.sh";
    p.jobs = jobs;
    return p;
  }
  CampaignProgress fly(const std::string& out, std::uint64_t runs, const CampaignPlan& p) {
    const CampaignFolder folder(scratch.path(out), identity(runs), CampaignUse::alone);
    return run_campaign(folder, p, go_on_always);
  }
  CampaignMerge merge(const std::string& out) {
    return merge_campaign(CampaignFolder(scratch.path(out), CampaignUse::alone));
  }
  std::string text(const std::string& name) { return text_if_there(scratch.path(name)).value_or("(not there)"); }
  void check_same_summary(const std::string& one, const std::string& other) {
    for (const char* name : reduced_files) {
      const std::string wanted = text(one + "/" + name);
      CHECK_TEXT(wanted.size() > 20, wanted.c_str());
      STRCMP_EQUAL_TEXT(wanted.c_str(), text(other + "/" + name).c_str(), name);
    }
  }
  bool holds(const std::string& whole, const std::string& piece) { return whole.find(piece) != std::string::npos; }
  std::string fly_error(const std::string& out, std::uint64_t runs, const CampaignPlan& p) {
    return message_of([&] { fly(out, runs, p); });
  }
};

TEST(Campaign, OneRunIsOneResultWhateverJobsAndOrder) {
  scenario_with("lost 4\n");
  const CampaignProgress one = fly("one", 30, plan(1));
  CHECK_EQUAL(30, one.done);
  CHECK_EQUAL(1, one.failed);
  CHECK_EQUAL(1, merge("one").failures);
  CHECK_EQUAL(30, fly("two", 30, plan(2)).done);
  merge("two");
  check_same_summary("one", "two");
  // Slices, the last one first, one of them twice.
  for (const std::uint64_t first : {20U, 10U, 0U, 10U}) {
    CampaignPlan p = plan(3);
    p.first = first;
    p.count = 10;
    const CampaignFolder folder(scratch.path("slices"), identity(30), CampaignUse::beside_others);
    run_campaign(folder, p, go_on_always);
  }
  merge("slices");
  check_same_summary("one", "slices");
}

TEST(Campaign, CrashesHangsAndSilenceAreErrorsThatNameTheirCause) {
  scenario_with("crash 1\nsilent 2\nhalf 3\nstatus3 4\nhang 5\nlost 6\n");
  CampaignPlan p = plan(2);
  p.time_limit_s = 2.0;
  p.scenario_seed = 7;
  const CampaignProgress progress = fly("c", 8, p);
  CHECK_EQUAL(8, progress.done);
  CHECK_EQUAL(6, progress.failed);
  const CampaignMerge merged = merge("c");
  CHECK_EQUAL(6, merged.failures);
  CHECK_EQUAL(5, merged.errors);
  CHECK_EQUAL(0, merged.missing);
  const std::string again = "relnav sim --scenario " + scenario + " --run ";
  const auto seed = [](std::uint64_t run) { return std::to_string(relnav::hil::seed_of_run(7, {run})); };
  STRCMP_EQUAL(("run,seed,outcome,problem,command\n"
                "1," +
                seed(1) + ",error,ended by signal 11 (SIGSEGV)," + again +
                "1 --out run-1\n"
                "2," +
                seed(2) + ",error,ended with exit status 0 and without a result," + again +
                "2 --out run-2\n"
                "3," +
                seed(3) + ",error,ended with exit status 0 and without a result," + again +
                "3 --out run-3\n"
                "4," +
                seed(4) + ",error,ended with exit status 3," + again +
                "4 --out run-4\n"
                "5," +
                seed(5) + ",error,took longer than 2 s," + again +
                "5 --out run-5\n"
                "6,9876543216,lost,lost at 12.6 s," +
                again + "6 --out run-6\n")
                   .c_str(),
               text("c/failures.csv").c_str());
  CHECK_EQUAL(0, fly("c", 8, p).done);  // they are results
  p.errors_again = true;
  scenario_with("crash 1\nsilent 2\nhalf 3\nstatus3 4\nhang 5\nlost 6\n");
  CHECK_EQUAL(5, fly("c", 8, p).done);
}

TEST(Campaign, UnusableInputEndsTheCampaign) {
  scenario_with("unusable 3\n");
  CHECK_MESSAGE_HOLDS(fly_error("u", 8, plan(2)), "run 3: " + scenario + ":7: the inertia is negative");
  CampaignPlan p = plan(1);
  p.program = scratch.path("nowhere");
  CHECK_MESSAGE_HOLDS(fly_error("v", 8, p), "cannot be started");
}

TEST(Campaign, HalfAndForeignResultsAreDoneAgain) {
  fly("h", 12, plan(2));
  merge("h");
  const std::string before = text("h/summary.json");
  const std::string whole = text("h/runs/0/3.json");
  scratch.write("h/runs/0/3.json", whole.substr(0, whole.size() / 2));
  scratch.write("h/runs/0/4.json", "");
  scratch.write("h/runs/0/5.json", whole);  // of another run
  scratch.write("h/runs/0/6.json", test::replaced(text("h/runs/0/6.json"), "tracked", "tracket"));
  fs::remove(scratch.path("h/runs/0/7.json"));
  scratch.write("h/runs/0/7.part", whole);
  const CampaignMerge merged = merge("h");
  CHECK_EQUAL(5, merged.missing);
  CHECK_EQUAL(3, *merged.first_missing);
  CHECK(holds(text("h/summary.json"), "\"missing\": 5"));
  const CampaignProgress again = fly("h", 12, plan(2));
  CHECK_EQUAL(5, again.done);
  CHECK_EQUAL(7, again.there);
  merge("h");
  STRCMP_EQUAL(before.c_str(), text("h/summary.json").c_str());
}

TEST(Campaign, AnotherCampaignsFolderIsRefused) {
  fly("a", 4, plan(2));
  CHECK_MESSAGE_HOLDS(fly_error("a", 3, plan(1)), "holds a campaign of 4 runs");
  CHECK_MESSAGE_HOLDS(message_of([&] {
                        CampaignFolder(scratch.path("a"), campaign_identity(scenario, 4, "0.2.0"), CampaignUse::alone);
                      }),
                      "made by version 0.1.0");
  scenario_with("lost 1\n");
  CHECK_MESSAGE_HOLDS(fly_error("a", 4, plan(1)), "holds another campaign, of " + scenario + " with CRC ");
  scratch.write("b/notes.txt", "mine");
  CHECK_MESSAGE_HOLDS(fly_error("b", 4, plan(1)), "is not empty and holds no campaign");
  CHECK_MESSAGE_HOLDS(message_of([&] { merge("b"); }), "holds no campaign");
  scratch.write("c/campaign.json", "{\"scenario\": \"spin");
  CHECK_MESSAGE_HOLDS(fly_error("c", 4, plan(1)), "campaign.json: is damaged");
  scratch.write("d/.relnav-x7Gh2K", "{\"scen");  // killed when it began
  CHECK_EQUAL(4, fly("d", 4, plan(2)).done);
  CHECK(!fs::exists(scratch.path("d/.relnav-x7Gh2K")));
}

TEST(Campaign, OneAtATimeButSlicesBesideEachOther) {
  const std::string out = scratch.path("o");
  const auto open = [&](CampaignUse use) { return message_of([&] { CampaignFolder(out, identity(4), use); }); };
  {
    const CampaignFolder slice(out, identity(4), CampaignUse::beside_others);
    STRCMP_EQUAL("", open(CampaignUse::beside_others).c_str());
    CHECK_MESSAGE_HOLDS(open(CampaignUse::alone), "is in use");
  }
  const CampaignFolder alone(out, identity(4), CampaignUse::alone);
  CHECK_MESSAGE_HOLDS(open(CampaignUse::beside_others), "is in use");
}

TEST(Campaign, AChangedFileThatTheScenarioNamesIsNoticed) {
  fly("f", 4, plan(2));
  scratch.write("spin.crc", "600dcafe\n");
  CHECK_MESSAGE_HOLDS(fly_error("f", 8, plan(1)), "is of a scenario with CRC 600dcafe (expected CRC 0badcafe");
}

TEST(Campaign, MoreRunsExtendIt) {
  fly("e", 6, plan(2));
  const CampaignProgress more = fly("e", 9, plan(2));
  CHECK_EQUAL(3, more.done);
  CHECK_EQUAL(6, more.there);
  merge("e");
  fly("whole", 9, plan(2));
  merge("whole");
  check_same_summary("whole", "e");
}

TEST(Campaign, InterruptedItEndsItsRunsAndGoesOnLater) {
  scenario_with("hang 3\n");
  const CampaignFolder folder(scratch.path("i"), identity(6), CampaignUse::alone);
  const CampaignProgress p = run_campaign(folder, plan(2), [](const CampaignProgress& now) { return now.done < 5; });
  CHECK(p.interrupted);
  CHECK_EQUAL(5, p.done);
  CHECK(!fs::exists(folder.result_path(3)));
  STRCMP_EQUAL(
      "", message_of([&] { run_campaign(folder, plan(2), [](const CampaignProgress&) { return false; }); }).c_str());
}

TEST(Campaign, KilledAtAnyMomentItGoesOn) {
  constexpr std::uint64_t runs = 40;
  fly("whole", runs, plan(2));
  merge("whole");
  std::size_t kills = 0;
  for (unsigned after_ms = 20; after_ms < 600; after_ms += 60) {
    const pid_t child = ::fork();
    if (child == 0) {
      try {
        fly("k", runs, plan(2));
        merge("k");
      } catch (...) {
        ::_exit(1);
      }
      ::_exit(0);
    }
    ::usleep(after_ms * 1000);
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    kills += WIFSIGNALED(status) ? 1U : 0U;
    if (!WIFSIGNALED(status)) {
      CHECK_EQUAL(0, WEXITSTATUS(status));
      break;
    }
  }
  CHECK_TEXT(kills > 0, "never killed while at work");
  fly("k", runs, plan(2));
  merge("k");
  check_same_summary("whole", "k");
}

TEST_GROUP(CampaignPack) {
  Scratch scratch;
  CampaignIdentity identity{"/s.yaml", "12345678", "0.1.0", 2500};
  std::string out = scratch.path("p");

  static std::string result(std::uint64_t run) {
    const std::string n = std::to_string(run);
    return "{\"scenario\": \"spin\",\n \"scenario_crc\": \"12345678\", \"version\": \"0.1.0\", \"run\": " + n +
           ", \"seed\": " + n +
           ",\n \"outcome\": \"tracked\", \"problem\": \"\", \"frames\": 1, \"poses\": 1, \"invalid_flagged_valid\": "
           "0,\n"
           " \"figures\": {\"n\": " +
           n + "}, \"nees\": {\"sum\": 6.5, \"count\": 1, \"dof\": 6}, \"dispersed\": {}, \"wall_s\": 1}\n";
  }
  void fill(std::uint64_t first, std::uint64_t end) const {
    for (std::uint64_t k = first; k < end; ++k)
      scratch.write("p/runs/" + std::to_string(k / 1000) + "/" + std::to_string(k) + ".json", result(k));
  }
  bool there(const std::string& name) const { return fs::exists(scratch.path("p/" + name)); }
  std::string text(const std::string& name) const { return text_if_there(scratch.path("p/" + name)).value_or(""); }
};

TEST(CampaignPack, AFinishedThousandBecomesOneFileAndNothingChanges) {
  const CampaignFolder folder(out, identity, CampaignUse::alone);
  fill(0, 2500);
  fs::remove(scratch.path("p/runs/1/1500.json"));
  CHECK(folder.pack(0));
  CHECK(!folder.pack(1));  // one is missing
  CHECK(!folder.pack(2));  // no whole thousand
  CHECK(there("runs/0.jsonl") && !there("runs/0"));
  CHECK(!there("runs/1.jsonl") && there("runs/1/1999.json"));
  std::uint64_t next = 0;
  std::uint64_t missing = 0;
  folder.visit_results(0, 2500, [&](std::uint64_t run, const RunResult* r) {
    CHECK_EQUAL(next, run);
    ++next;
    if (r == nullptr) {
      ++missing;
    } else {
      CHECK_EQUAL(run, r->run);
      DOUBLES_EQUAL(static_cast<double>(run), r->figures.front().second, 0.0);
    }
  });
  CHECK_EQUAL(2500, next);
  CHECK_EQUAL(1, missing);
  const CampaignMerge merged = merge_campaign(folder);
  CHECK_EQUAL(1500, *merged.first_missing);
  const std::string before = text("summary.json");
  fill(1500, 1501);
  CHECK_EQUAL(0, merge_campaign(folder).missing);  // packs what has become complete
  CHECK(there("runs/1.jsonl") && !there("runs/1"));
  CHECK(before != text("summary.json"));
  const std::string after = text("summary.json");
  merge_campaign(folder);
  STRCMP_EQUAL(after.c_str(), text("summary.json").c_str());
}

TEST(CampaignPack, KilledInBetweenItIsDoneAgain) {
  const CampaignFolder folder(out, identity, CampaignUse::alone);
  fill(0, 1000);
  CHECK(folder.pack(0));
  const std::string packed = text("runs/0.jsonl");
  // Killed before the rename: the single files count.
  fs::remove(scratch.path("p/runs/0.jsonl"));
  scratch.write("p/runs/.relnav-abc123", packed.substr(0, packed.size() / 2));
  fill(0, 1000);
  CHECK(folder.pack(0));
  STRCMP_EQUAL(packed.c_str(), text("runs/0.jsonl").c_str());
  // Killed while single files were removed.
  fill(600, 1000);
  CHECK(folder.pack(0));
  STRCMP_EQUAL(packed.c_str(), text("runs/0.jsonl").c_str());
  CHECK(!there("runs/0"));
}

TEST(CampaignPack, ADamagedLineIsOneRunToDoAgain) {
  const CampaignFolder folder(out, identity, CampaignUse::alone);
  fill(0, 1000);
  CHECK(folder.pack(0));
  const std::string packed = text("runs/0.jsonl");
  scratch.write("p/runs/0.jsonl", test::replaced(packed, "\"run\":17,", "\"run\":17"));
  std::vector<std::uint64_t> missing;
  folder.visit_results(0, 1000, [&](std::uint64_t run, const RunResult* r) {
    if (r == nullptr) missing.push_back(run);
  });
  CHECK_EQUAL(1, missing.size());
  CHECK_EQUAL(17, missing.front());
  fill(17, 18);
  CHECK(folder.pack(0));
  STRCMP_EQUAL(packed.c_str(), text("runs/0.jsonl").c_str());
}
