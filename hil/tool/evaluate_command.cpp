#include <cstdio>
#include <fstream>
#include <map>
#include <memory>

#include "hil/evaluate/evaluation.hpp"
#include "hil/tool/commands.hpp"
#include "platform/files/input_error.hpp"

namespace relnav::hil {
namespace {

struct EvaluateOptions {
  std::string truth;
  std::string estimate;
  std::string covariance;
  std::string json;
  AlignMode align = AlignMode::none;
};

int run(const EvaluateOptions& options) {
  const Trajectory truth = read_trajectory(options.truth);
  const Trajectory estimate = read_trajectory(options.estimate);
  std::vector<TimedCovariance> covariances;
  if (!options.covariance.empty()) covariances = read_covariances(options.covariance);
  Evaluation result;
  try {
    result = evaluate(truth, estimate, options.covariance.empty() ? nullptr : &covariances, options.align);
  } catch (const std::runtime_error& error) {
    throw InputError(options.estimate, 0, error.what(), "a trajectory comparable with " + options.truth);
  }
  if (options.json == "-") {
    std::fputs(evaluation_json(result).c_str(), stdout);
    return exit_done;
  }
  std::fputs(evaluation_text(result).c_str(), stdout);
  if (!options.json.empty()) {
    std::ofstream out(options.json);
    out << evaluation_json(result) << std::flush;
    if (!out) throw InputError(options.json, 0, "cannot be written", "a writable file");
  }
  return exit_done;
}

}  // namespace

void add_evaluate_command(CLI::App& app, int& exit_status) {
  const auto options = std::make_shared<EvaluateOptions>();
  CLI::App* command = app.add_subcommand("evaluate", "Compare a trajectory with the truth");
  command->add_option("--truth", options->truth, "TUM file, poses T_CT of the truth")->required();
  command->add_option("--estimate", options->estimate, "TUM file, poses T_CT to judge")->required();
  command->add_option("--cov", options->covariance, "CSV with the pose covariances of the estimate (gives the NEES)");
  const std::map<std::string, AlignMode> modes{
      {"none", AlignMode::none}, {"se3", AlignMode::se3}, {"sim3", AlignMode::sim3}, {"start", AlignMode::start}};
  command
      ->add_option(
          "--align", options->align,
          "none; se3, sim3: target frames matched over the camera centres; start: both referred to the first common "
          "epoch, one scale and one body point fitted")
      ->transform(CLI::CheckedTransformer(modes))
      ->option_text("none|se3|sim3|start [none]");
  command->add_option("--json", options->json,
                      "Also write the figures to this file (- : to standard output, instead of the text)");
  command->callback([options, &exit_status] { exit_status = run(*options); });
}

}  // namespace relnav::hil
