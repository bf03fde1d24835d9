#include <nlohmann/json.hpp>

#include "hil/evaluate/evaluation.hpp"
#include "hil/evaluate/rotation.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

std::string statistics_lines(const char* name, const char* unit, const ErrorStatistics& s, double factor) {
  const auto axis = [factor](const Vec3& v) {
    return format_text("%10.5f %10.5f %10.5f", factor * v.x(), factor * v.y(), factor * v.z());
  };
  return format_text("%-15s %-6s RMS %10.5f   mean %10.5f   max %10.5f at %s s   last %10.5f\n", name, unit,
                     factor * s.rms, factor * s.mean, factor * s.max, format_seconds(s.max_time.ns).c_str(),
                     factor * s.last) +
         format_text("%22s per axis x y z: RMS %s   max %s\n", "", axis(s.rms_axis).c_str(), axis(s.max_axis).c_str());
}

const char* position_meaning(AlignMode align) {
  switch (align) {
    case AlignMode::none: return "target origin t_CT, axes of C";
    case AlignMode::start: return "fitted body point, axes of C";
    case AlignMode::se3:
    case AlignMode::sim3: return "camera centre, axes of the truth's T";
  }
  return "";
}

std::string alignment_lines(const Evaluation& e) {
  std::string text = format_text("alignment       %s", to_string(e.align));
  if (e.similarity) {
    const Similarity& s = *e.similarity;
    const Vec3 angle = rotation_vector(s.R) * degrees_per_radian;
    text += format_text(": scale %.6f, rotation vector [%.4f %.4f %.4f] deg, shift [%.5f %.5f %.5f]", s.scale,
                        angle.x(), angle.y(), angle.z(), s.t.x(), s.t.y(), s.t.z());
    if (s.rotation_from_attitudes) text += "; rotation from the attitudes (the positions lie on a line)";
  } else if (e.body_point) {
    const BodyPointFit& b = *e.body_point;
    text += format_text(
        ": attitude referred to the first common epoch; scale %.6f, body point [%.4f %.4f %.4f] m in the truth's T",
        b.scale, b.b_T.x(), b.b_T.y(), b.b_T.z());
    text += format_text(" (rank %d of 4, condition %.3g%s)", b.rank, b.condition,
                        b.rank < 4 ? ": minimum-norm solution" : "");
  }
  return text + "\n";
}

std::string epoch_lines(const Evaluation& e) {
  std::string text =
      format_text("poses           truth %zu, estimate %zu, compared %zu (stamps within %.3f ms)\n", e.truth_poses,
                  e.estimate_poses, e.epochs.size(), static_cast<double>(e.association.tolerance.ns) * 1e-6);
  text += format_text("missing epochs  %zu of the truth without estimate, %zu estimates without truth",
                      e.missing.size(), e.association.estimates_without_truth);
  constexpr std::size_t most_shown = 5;
  for (std::size_t i = 0; i < e.missing.size() && i < most_shown; ++i) {
    text += (i == 0 ? ": " : ", ") + format_seconds(e.missing[i].ns);
  }
  if (e.missing.size() > most_shown) text += ", ...";
  return text + "\n";
}

std::string rate_lines(const Evaluation& e) {
  if (e.rates.empty()) return "rates           too few epochs\n";
  constexpr double deg = degrees_per_radian;
  std::string text = format_text(
      "rate definition: rotation vector from t - w/2 to t + w/2 divided by w, w = %.3f s (1 s, at least 10 epochs), "
      "axes of C; velocity likewise\n",
      e.rate_window.seconds());
  text += statistics_lines("rate error", "deg/s", e.rate, deg);
  text += format_text(
      "mean rate       deg/s  truth %.5f, estimate %.5f, difference %.5f (angle over time, windows end to end)\n",
      e.truth_mean_rate * deg, e.estimate_mean_rate * deg, (e.estimate_mean_rate - e.truth_mean_rate) * deg);
  return text + statistics_lines("velocity error", "m/s", e.velocity, 1.0);
}

std::string nees_lines(const NeesStatistics& n) {
  std::string text = format_text("NEES            %d dof, %zu epochs", n.degrees_of_freedom, n.epochs);
  if (n.epochs > 0) {
    text += format_text(
        ": mean %.3f (95 %% chi-square band %.3f to %.3f for independent epochs), %.1f %% of epochs inside %.3f to "
        "%.3f (95 %% for one epoch)",
        n.mean, n.mean_low, n.mean_high, 100.0 * n.inside, n.epoch_low, n.epoch_high);
  }
  if (n.without_covariance > 0) text += format_text("; %zu epochs without covariance", n.without_covariance);
  if (n.not_positive_definite > 0)
    text += format_text("; %zu covariances not positive definite", n.not_positive_definite);
  return text + "\n";
}

nlohmann::ordered_json vector_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::ordered_json statistics_json(const ErrorStatistics& s) {
  return {{"rms", s.rms},
          {"mean", s.mean},
          {"max", s.max},
          {"max_t_ns", s.max_time.ns},
          {"last", s.last},
          {"rms_axis", vector_json(s.rms_axis)},
          {"max_axis", vector_json(s.max_axis)}};
}

}  // namespace

std::string evaluation_text(const Evaluation& e) {
  std::string text = epoch_lines(e) + alignment_lines(e);
  text += format_text("position is     %s\n", position_meaning(e.align));
  text += statistics_lines("position error", "m", e.position, 1.0);
  if (e.extent > 0.0) {
    text += format_text(
        "%22s RMS %.4f %%, max %.4f %% of the extent of the path, %.5f m (largest distance between two reference "
        "positions)\n",
        "", 100.0 * e.position.rms / e.extent, 100.0 * e.position.max / e.extent, e.extent);
  }
  if (e.similarity && !e.similarity->rotation_from_attitudes) {
    if (e.position_rms_by_attitudes) {
      text += format_text("%22s RMS %.5f m with the rotation taken from the attitudes instead", "",
                          *e.position_rms_by_attitudes);
      if (e.extent > 0.0)
        text += format_text(", %.4f %% of the extent", 100.0 * *e.position_rms_by_attitudes / e.extent);
      text += "\n";
    } else {
      text += format_text(
          "%22s WARNING: with the rotation taken from the attitudes the scale is negative: the estimate moves against "
          "the truth (mirrored)\n",
          "");
    }
    constexpr double nearly_straight = 0.1;
    if (e.similarity->straightness < nearly_straight) {
      text += format_text(
          "%22s the path is nearly straight (spread across %.1f %% of that along it): the rotation about it, and with "
          "it the attitude error, is hardly determined by the positions\n",
          "", 100.0 * e.similarity->straightness);
    }
  }
  text += statistics_lines("attitude error", "deg", e.attitude, degrees_per_radian);
  text += format_text("%22s truth turned %.4f deg (sum of the steps)", "", e.angle_turned * degrees_per_radian);
  if (e.angle_turned > 1e-6)
    text += format_text("; last error is %.3f %% of it", 100.0 * e.attitude.last / e.angle_turned);
  text += "\n" + rate_lines(e);
  if (e.nees) text += nees_lines(*e.nees);
  return text;
}

std::string evaluation_json(const Evaluation& e) {
  nlohmann::ordered_json json;
  json["align"] = to_string(e.align);
  json["truth_poses"] = e.truth_poses;
  json["estimate_poses"] = e.estimate_poses;
  json["compared_epochs"] = e.epochs.size();
  json["missing_epochs"] = e.missing.size();
  json["estimates_without_truth"] = e.association.estimates_without_truth;
  if (e.similarity) {
    json["scale"] = e.similarity->scale;
    json["rotation_vector_rad"] = vector_json(rotation_vector(e.similarity->R));
    json["shift_m"] = vector_json(e.similarity->t);
    json["position_rms_m_by_attitudes"] =
        e.position_rms_by_attitudes ? nlohmann::ordered_json(*e.position_rms_by_attitudes) : nullptr;
    json["straightness"] = e.similarity->straightness;
    json["rotation_from_attitudes"] = e.similarity->rotation_from_attitudes;
  }
  if (e.body_point) {
    json["scale"] = e.body_point->scale;
    json["body_point_m"] = vector_json(e.body_point->b_T);
    json["fit_rank"] = e.body_point->rank;
  }
  json["position_meaning"] = position_meaning(e.align);
  json["position_m"] = statistics_json(e.position);
  json["extent_m"] = e.extent;
  if (e.extent > 0.0) json["position_rms_percent_of_extent"] = 100.0 * e.position.rms / e.extent;
  json["attitude_rad"] = statistics_json(e.attitude);
  json["angle_turned_rad"] = e.angle_turned;
  if (e.angle_turned > 1e-8) json["attitude_last_percent_of_angle_turned"] = 100.0 * e.attitude.last / e.angle_turned;
  json["rate_window_s"] = e.rate_window.seconds();
  json["rate_rad_s"] = statistics_json(e.rate);
  json["truth_mean_rate_rad_s"] = e.truth_mean_rate;
  json["estimate_mean_rate_rad_s"] = e.estimate_mean_rate;
  json["velocity_m_s"] = statistics_json(e.velocity);
  if (e.nees) {
    json["nees"] = {{"dof", e.nees->degrees_of_freedom},
                    {"epochs", e.nees->epochs},
                    {"mean", e.nees->mean},
                    {"mean_band_95", {e.nees->mean_low, e.nees->mean_high}},
                    {"epoch_band_95", {e.nees->epoch_low, e.nees->epoch_high}},
                    {"share_inside", e.nees->inside},
                    {"without_covariance", e.nees->without_covariance},
                    {"not_positive_definite", e.nees->not_positive_definite}};
  }
  return json.dump(2) + "\n";
}

}  // namespace relnav::hil
