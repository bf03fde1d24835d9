// How the results of a campaign are reduced.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "hil/evaluate/chi_square.hpp"
#include "hil/io/atomic_file.hpp"
#include "hil/montecarlo/campaign_summary.hpp"
#include "hil/montecarlo/distribution.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::Scratch;

TEST_GROUP(CampaignFigures){};

TEST(CampaignFigures, PercentilesOfKnownValues) {
  std::vector<double> values(101);
  std::iota(values.begin(), values.end(), 0.0);
  std::reverse(values.begin(), values.end());
  const Distribution d = distribution_of(values);
  for (std::size_t k = 0; k < percentile_points.size(); ++k)
    DOUBLES_EQUAL(percentile_points[k], d.percentiles[k], 1e-12);
  DOUBLES_EQUAL(50.0, d.moments.mean(), 1e-12);
  DOUBLES_EQUAL(std::sqrt(101.0 * 102.0 / 12.0), d.moments.sd(), 1e-9);
  DOUBLES_EQUAL(0.0, d.moments.min(), 0.0);
  DOUBLES_EQUAL(100.0, d.moments.max(), 0.0);
  DOUBLES_EQUAL(1.5, distribution_of({1.0, 2.0}).percentiles[3], 1e-12);
  DOUBLES_EQUAL(7.0, distribution_of({7.0}).percentiles[6], 0.0);
  CHECK_EQUAL(0, distribution_of({}).moments.count());
}

TEST(CampaignFigures, HistogramHoldsAllAndKeepsOutliersOut) {
  std::vector<double> values;
  for (int k = 0; k < 1000; ++k) values.push_back(k % 100);
  values.push_back(1e6);
  values.push_back(-1e6);
  const Histogram h = distribution_of(values).histogram;
  CHECK_EQUAL(1, h.below);
  CHECK_EQUAL(1, h.above);
  CHECK_EQUAL(1000, std::accumulate(h.counts.begin(), h.counts.end(), std::uint64_t{0}));
  const Histogram same = distribution_of({3.0, 3.0, 3.0}).histogram;
  CHECK_EQUAL(1, same.counts.size());
  CHECK_EQUAL(3, same.counts.front());
}

TEST(CampaignFigures, WilsonsInterval) {
  // Newcombe 1998, table I: 81 of 263 gives 0.2553 to 0.3662; 15 of 148 gives 0.0624 to 0.1605; 0 of 20 0 to 0.1611.
  const auto [a, b] = wilson_95(81, 263);
  DOUBLES_EQUAL(0.2553, a, 5e-5);
  DOUBLES_EQUAL(0.3662, b, 5e-5);
  const auto [c, d] = wilson_95(15, 148);
  DOUBLES_EQUAL(0.0624, c, 5e-5);
  DOUBLES_EQUAL(0.1605, d, 5e-5);
  const auto [e, f] = wilson_95(0, 20);
  DOUBLES_EQUAL(0.0, e, 0.0);
  DOUBLES_EQUAL(0.1611, f, 5e-5);
  const auto [g, h] = wilson_95(20, 20);
  DOUBLES_EQUAL(1.0 - 0.1611, g, 5e-5);
  DOUBLES_EQUAL(1.0, h, 0.0);
}

TEST(CampaignFigures, SummaryOfResultsWrittenByHand) {
  Scratch scratch;
  const std::string out = scratch.path("s");
  const CampaignFolder folder(out, {"/it's.yaml", "12345678", "0.1.0", 4}, CampaignUse::alone);
  const auto write = [&](int run, const char* outcome, const char* problem, double figure, double nees) {
    const std::string n = std::to_string(run);
    scratch.write("s/runs/0/" + n + ".json",
                  "{\"scenario\":\"spin\",\"scenario_crc\":\"abcd0123\",\"version\":\"0.1.0\",\"run\":" + n +
                      ",\"seed\":18446744073709551615,\"outcome\":\"" + outcome + "\",\"problem\":\"" + problem +
                      "\",\"frames\":10,\"poses\":9,\"invalid_flagged_valid\":" + (run == 2 ? "2" : "0") +
                      ",\"figures\":{\"e\":" + std::to_string(figure) + ",\"only_" + n +
                      "\":1},\"nees\":{\"sum\":" + std::to_string(nees) +
                      ",\"count\":50,\"dof\":6},\"dispersed\":{\"rate\":" + n + "},\"wall_s\":" + n + "}");
  };
  write(0, "tracked", "", 1.0, 300.0);
  write(1, "regained", "", 2.0, 310.0);
  write(2, "lost", "lost at 3.5 s, \\\"dark\\\"", 4.0, 600.0);
  write(3, "lost", "lost at 12 s, \\\"dark\\\"", 9.0, 290.0);
  const CampaignMerge merged = merge_campaign(folder);
  CHECK_EQUAL(2, merged.failures);
  CHECK_EQUAL(0, merged.errors);
  const auto s = nlohmann::json::parse(text_if_there(out + "/summary.json").value_or(""));
  STRCMP_EQUAL("abcd0123", s["scenario_crc"].get<std::string>().c_str());
  CHECK_EQUAL(2, s["outcomes"]["lost"]["count"].get<int>());
  DOUBLES_EQUAL(0.5, s["outcomes"]["lost"]["share"].get<double>(), 0.0);
  DOUBLES_EQUAL(wilson_95(2, 4).first, s["outcomes"]["lost"]["share_95"][0].get<double>(), 1e-15);
  CHECK_EQUAL(1, s["causes"].size());  // one cause, with other numbers in it
  STRCMP_EQUAL("lost at # s, \"dark\"", s["causes"][0]["problem"].get<std::string>().c_str());
  CHECK_EQUAL(2, s["causes"][0]["first_run"].get<int>());
  CHECK_EQUAL(40, s["frames"].get<int>());
  CHECK_EQUAL(1, s["invalid_flagged_valid"]["runs"].get<int>());
  DOUBLES_EQUAL(4.0, s["figures"]["e"]["mean"].get<double>(), 1e-12);
  DOUBLES_EQUAL(3.0, s["figures"]["e"]["percentiles"]["50"].get<double>(), 1e-12);
  CHECK_EQUAL(1, s["figures"]["only_3"]["count"].get<int>());
  DOUBLES_EQUAL(1500.0 / 1200.0, s["nees"]["mean"].get<double>(), 1e-12);
  DOUBLES_EQUAL(chi_square_quantile(0.025, 1200.0) / 1200.0, s["nees"]["band_95"][0].get<double>(), 1e-12);
  DOUBLES_EQUAL(0.75, s["nees"]["runs_in_their_band_95"].get<double>(), 1e-12);
  DOUBLES_EQUAL(1.5, s["dispersions"]["rate"]["mean"].get<double>(), 1e-12);
  DOUBLES_EQUAL(2.5, s["dispersions"]["rate"]["failed"]["mean"].get<double>(), 1e-12);
  STRCMP_EQUAL(
      "run,seed,outcome,problem,command\n"
      "2,18446744073709551615,lost,\"lost at 3.5 s, \"\"dark\"\"\",relnav sim --scenario '/it'\\''s.yaml' --run 2 "
      "--out run-2\n"
      "3,18446744073709551615,lost,\"lost at 12 s, \"\"dark\"\"\",relnav sim --scenario '/it'\\''s.yaml' --run 3 --out "
      "run-3\n",
      text_if_there(out + "/failures.csv").value_or("").c_str());
  CHECK(text_if_there(out + "/summary.json").value_or("").find("wall") == std::string::npos);
}

TEST(CampaignFigures, NeesBandOfManyRuns) {
  // 10^5 epochs of 6: the approximation takes over; both sides of the change agree.
  Scratch scratch;
  const CampaignFolder folder(scratch.path("n"), {"/s.yaml", "12345678", "0.1.0", 1}, CampaignUse::alone);
  const auto band = [&](std::uint64_t epochs) {
    scratch.write(
        "n/runs/0/0.json",
        "{\"scenario\":\"s\",\"scenario_crc\":\"1\",\"version\":\"0\",\"run\":0,\"seed\":1,\"outcome\":\"tracked\","
        "\"problem\":\"\",\"frames\":1,\"poses\":1,\"invalid_flagged_valid\":0,\"figures\":{},\"nees\":{\"sum\":6.0,"
        "\"count\":" +
            std::to_string(epochs) + ",\"dof\":6},\"dispersed\":{},\"wall_s\":1}");
    merge_campaign(folder);
    const auto s = nlohmann::json::parse(text_if_there(scratch.path("n/summary.json")).value_or(""));
    return s["nees"]["band_95"].get<std::vector<double>>();
  };
  const double dof = 6.0 * 20000.0;
  const auto large = band(20000);
  DOUBLES_EQUAL(chi_square_quantile(0.025, dof) / dof, large[0], 1e-8);
  DOUBLES_EQUAL(chi_square_quantile(0.975, dof) / dof, large[1], 1e-8);
}
