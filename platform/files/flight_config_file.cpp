#include "platform/files/flight_config_file.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <set>

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"
#include "platform/files/yaml_reader.hpp"

namespace relnav {
namespace {

/// Takes a value; answers what was expected instead, or nothing when it is fine.
using Setter = std::function<std::string(const std::string& text)>;
using Section = std::map<std::string, Setter>;

/// What a number may be, and what to call it.
struct Domain {
  bool (*holds)(double value);
  const char* name;
};
constexpr Domain finite{[](double) { return true; }, "a finite number"};
constexpr Domain positive{[](double x) { return x > 0.0; }, "a positive number"};
constexpr Domain not_negative{[](double x) { return x >= 0.0; }, "a number of at least 0"};
constexpr Domain over_one{[](double x) { return x > 1.0; }, "a number over 1"};
constexpr Domain at_least_one{[](double x) { return x >= 1.0; }, "a number of at least 1"};
constexpr Domain part{[](double x) { return x > 0.0 && x < 1.0; }, "a number between 0 and 1"};
constexpr Domain correlation{[](double x) { return x >= 0.0 && x <= 1.0; }, "a number from 0 to 1"};
constexpr Domain point_spread{[](double x) { return x >= 0.3 && x <= 3.0; }, "a number from 0.3 to 3"};
constexpr Domain factor{[](double x) { return x > 1.0 && x <= 1e3; }, "a number over 1, up to 1000"};
constexpr Domain gain{[](double x) { return x >= 1e-6 && x <= 1e6; }, "a number from 1e-6 to 1e6"};

Setter real(double& target, const Domain& domain) {
  return [&target, &domain](const std::string& text) -> std::string {
    const auto value = parse_double(text);
    if (!value || !std::isfinite(*value) || !domain.holds(*value)) return domain.name;
    target = *value;
    return {};
  };
}

template <typename Integer>
constexpr std::int64_t largest = std::numeric_limits<Integer>::digits >= 63
                                     ? std::numeric_limits<std::int64_t>::max()
                                     : static_cast<std::int64_t>(std::numeric_limits<Integer>::max());

template <typename Integer>
Setter whole(Integer& target, std::int64_t low = static_cast<std::int64_t>(std::numeric_limits<Integer>::min()),
             std::int64_t high = largest<Integer>) {
  return [&target, low, high](const std::string& text) -> std::string {
    const auto value = parse_int64(text);
    if (!value || *value < low || *value > high)
      return "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
    target = static_cast<Integer>(*value);
    return {};
  };
}

Setter apid_base(telemetry::PacketConfig& target) {
  return [&target](const std::string& text) -> std::string {
    telemetry::PacketConfig packets = target;
    const std::string expected = whole(packets.apid_base)(text);
    if (!expected.empty()) return expected;
    if (telemetry::validate(packets) != Status::ok)
      return std::to_string(telemetry::packet_count) + " APIDs that are free, see the telemetry ICD";
    target = packets;
    return {};
  };
}

Setter yes_no(bool& target) {
  return [&target](const std::string& text) -> std::string {
    if (text != "true" && text != "false") return "true or false";
    target = text == "true";
    return {};
  };
}

Setter chart(AttitudeChartKind& target) {
  return [&target](const std::string& text) -> std::string {
    if (text != "mrp" && text != "rodrigues") return "mrp or rodrigues";
    target = text == "mrp" ? AttitudeChartKind::mrp : AttitudeChartKind::rodrigues;
    return {};
  };
}

Setter dark_action(app::DarkAction& target) {
  return [&target](const std::string& text) -> std::string {
    if (text != "hold" && text != "raise") return "hold or raise";
    target = text == "raise" ? app::DarkAction::raise : app::DarkAction::hold;
    return {};
  };
}

/// A length of time in whole microseconds.
Setter microseconds(Duration& target) {
  return [&target](const std::string& text) -> std::string {
    std::int64_t us = 0;
    const std::string expected = whole(us, 1, 60'000'000)(text);
    if (expected.empty()) target = {us * 1000};
    return expected;
  };
}

std::map<std::string, Section> sections_of(app::FlightLoopConfig& c) {
  NoncoopConfig& f = c.navigator.filter;
  // The start adjustment of a rigid target divides by these.
  const Domain& of_start = f.motion == MotionKind::rigid_target ? positive : not_negative;
  return {
      {"filter",
       {{"chart", chart(f.chart)},
        {"inertia_second", real(f.inertia.second, positive)},
        {"inertia_third", real(f.inertia.third, positive)},
        {"inertia_phi_x_rad", real(f.inertia.phi_TP.x(), finite)},
        {"inertia_phi_y_rad", real(f.inertia.phi_TP.y(), finite)},
        {"inertia_phi_z_rad", real(f.inertia.phi_TP.z(), finite)},
        {"range_m", real(f.range_m, positive)},
        {"range_sigma_m", real(f.range_sigma_m, not_negative)},
        {"rate_sigma_rad_s", real(f.rate_sigma_rad_s, of_start)},
        {"velocity_sigma_per_range", real(f.velocity_sigma_per_range, of_start)},
        {"acceleration_psd_per_range", real(f.acceleration_psd_per_range, not_negative)},
        {"angular_psd", real(f.angular_psd, not_negative)},
        {"relief_per_extent", real(f.relief_per_extent, not_negative)},
        {"min_relief", real(f.min_relief, of_start)},
        {"pixel_sigma_px", real(f.pixel_sigma_px, positive)},
        {"first_view_sigma_px", real(f.first_view_sigma_px, positive)},
        {"feature_walk_px2_per_deg", real(f.feature_walk_px2_per_deg, not_negative)},
        {"robust_sigma", real(f.robust_sigma, not_negative)},
        {"gate_chi2", real(f.gate_chi2, positive)},
        {"linearity_threshold", real(f.linearity_threshold, not_negative)},
        {"start_frames", whole(f.start_frames, 1)},
        {"start_duration_s", real(f.start_duration_s, not_negative)},
        {"start_angular_psd", real(f.start_angular_psd, of_start)},
        {"start_pixel_sigma_px", real(f.start_pixel_sigma_px, of_start)},
        {"rest_sigma_rad_s", real(f.rest_sigma_rad_s, of_start)},
        {"ransac_confidence", real(f.ransac.confidence, part)},
        {"ransac_threshold_sigma", real(f.ransac.threshold_sigma, positive)},
        {"ransac_max_hypotheses", whole(f.ransac.max_hypotheses, 1)},
        {"seed", whole(f.seed)}}},
      {"front_end",
       {{"fast_threshold", whole(c.navigator.fast_threshold)},
        {"min_start_features", whole(c.navigator.min_start_features)},
        {"min_score", real(c.navigator.tracker.min_score, correlation)},
        {"min_distance_px", real(c.navigator.spread.min_distance_px, not_negative)},
        {"cell_px", whole(c.navigator.spread.cell_px, 16)}}},
      {"cooperative",
       {{"expected_phi_x_rad", real(c.coop.phi_CT_expected.x(), finite)},
        {"expected_phi_y_rad", real(c.coop.phi_CT_expected.y(), finite)},
        {"expected_phi_z_rad", real(c.coop.phi_CT_expected.z(), finite)},
        {"expected_cone_rad", real(c.coop.expected_cone_rad, not_negative)},
        {"min_observations", whole(c.coop.min_observations, 4)},
        {"sensor_bits", whole(c.coop.sensor_bits, 8, 16)},
        {"gain_electrons_dn", real(c.coop.spots.gain_electrons_dn, positive)},
        {"read_noise_dn", real(c.coop.spots.read_noise_dn, not_negative)},
        {"psf_sigma_px", real(c.coop.spots.psf_sigma_px, point_spread)},
        {"min_contrast", real(c.coop.spots.min_contrast, part)},
        {"max_area_px", whole(c.coop.spots.max_area_px, c.coop.spots.min_area_px)},
        {"max_elongation", real(c.coop.spots.max_elongation, at_least_one)},
        {"sigma_floor_px", real(c.coop.spots.sigma_floor_px, not_negative)},
        {"model_sigma_px", real(c.coop.tracking.model_sigma_px, not_negative)},
        {"flux_ratio", real(c.coop.tracking.flux_ratio, over_one)},
        {"range_min_m", real(c.coop.search.range_min_m, positive)},
        {"range_max_m", real(c.coop.search.range_max_m, positive)},
        {"max_hypotheses", whole(c.coop.search.max_hypotheses, 1)},
        {"start_velocity_sigma_m_s", real(c.coop.filter.velocity_sigma_m_s, positive)},
        {"start_rate_sigma_rad_s", real(c.coop.filter.rate_sigma_rad_s, positive)},
        {"acceleration_psd", real(c.coop.filter.noise.acceleration_psd, not_negative)},
        {"angular_psd", real(c.coop.filter.noise.angular_psd, not_negative)},
        {"pair_tolerance_ns", whole(c.second.pair_tolerance.ns, 0)}}},
      {"exposure",
       {{"enabled", yes_no(c.exposure.enabled)},
        {"sample_step_px", whole(c.exposure.brightness.sample_step_px, 1, 16)},
        {"dark_level", whole(c.exposure.brightness.dark_level, 0, vision::saturated_level - 1)},
        {"bright_permille", whole(c.exposure.brightness.bright_permille, 1, 999)},
        {"saturated_permille", whole(c.exposure.brightness.saturated_permille, 0, 1000)},
        {"target_level", whole(c.exposure.target_level, 1, vision::saturated_level - 1)},
        {"ceiling_level", whole(c.exposure.ceiling_level, 1, vision::saturated_level - 1)},
        {"black_level", whole(c.exposure.black_level, 0, vision::saturated_level - 1)},
        {"dead_band", real(c.exposure.dead_band, factor)},
        {"max_step", real(c.exposure.max_step, factor)},
        {"settle_frames", whole(c.exposure.settle_frames)},
        {"min_bright_samples", whole(c.exposure.min_bright_samples, 1)},
        {"dark_frames", whole(c.exposure.dark_frames, 1)},
        {"when_dark", dark_action(c.exposure.when_dark)},
        {"min_us", microseconds(c.exposure.exposure_min)},
        {"max_us", microseconds(c.exposure.exposure_max)},
        {"start_us", microseconds(c.exposure.exposure_start)},
        {"gain_min", real(c.exposure.gain_min, gain)},
        {"gain_max", real(c.exposure.gain_max, gain)}}},
      {"loop",
       {{"scale_known", yes_no(c.scale_known)},
        {"features_every_frames", whole(c.features_every_frames)},
        {"health_every_frames", whole(c.health_every_frames)},
        {"event_spacing_frames", whole(c.event_spacing_frames)},
        {"lost_after_frames", whole(c.lost_after_frames, 1)},
        {"min_inliers", whole(c.min_inliers)},
        {"min_contrast", whole(c.frames.min_contrast)},
        {"refuse_frozen", yes_no(c.frames.refuse_frozen)},
        {"max_age_ns", whole(c.frames.max_age.ns, 0)},
        {"acquire_wait_ns", whole(c.acquire_wait.ns, 0)},
        {"apid_base", apid_base(c.packets)}}},
  };
}

std::string names_of(const auto& map) {
  std::string names;
  for (const auto& [name, value] : map) names += (names.empty() ? "" : ", ") + name;
  return names;
}

/// Of every key given, as `section.key`.
using Lines = std::map<std::string, int>;

void read_section(const std::string& path, const std::string& name, const YAML::Node& node, const Section& keys,
                  Lines& lines) {
  if (node.IsNull()) return;  // all defaults
  if (!node.IsMap())
    throw InputError(path, line_of(node), "section '" + name + "' holds no keys", "keys of " + names_of(keys));
  for (const auto& entry : node) {
    const std::string key = entry.first.Scalar();
    const auto setter = keys.find(key);
    if (setter == keys.end())
      throw InputError(path, line_of(entry.first), "unknown key " + in_quotes(name + "." + key),
                       "one of " + names_of(keys));
    if (lines.contains(name + "." + key))
      throw InputError(path, line_of(entry.first), "key " + in_quotes(name + "." + key) + " a second time", "it once");
    const std::string expected = entry.second.IsScalar() ? setter->second(entry.second.Scalar()) : "a single value";
    if (!expected.empty()) {
      throw InputError(
          path, line_of(entry.first),
          name + "." + key + " is " + in_quotes(entry.second.IsScalar() ? entry.second.Scalar() : "a list or map"),
          expected);
    }
    lines[name + "." + key] = line_of(entry.first);
  }
}

/// The last of these keys that was given; 0: none was.
int last_line_of(const Lines& lines, std::initializer_list<const char*> keys) {
  int last = 0;
  for (const char* key : keys) {
    const auto line = lines.find(key);
    if (line != lines.end()) last = std::max(last, line->second);
  }
  return last;
}

/// Values that are good each by itself, but not together.
void check_exposure(const std::string& path, const app::AutoExposureConfig& e, const Lines& lines) {
  const auto refuse = [&](std::initializer_list<const char*> keys, const std::string& problem, const char* expected) {
    throw InputError(path, last_line_of(lines, keys), problem, expected);
  };
  if (e.black_level > e.brightness.dark_level || e.brightness.dark_level >= e.target_level ||
      e.target_level >= e.ceiling_level) {
    refuse({"exposure.black_level", "exposure.dark_level", "exposure.target_level", "exposure.ceiling_level"},
           format_text("exposure.black_level is %d, dark_level %d, target_level %d, ceiling_level %d", e.black_level,
                       e.brightness.dark_level, e.target_level, e.ceiling_level),
           "black_level not over dark_level, this under target_level, and that under ceiling_level");
  }
  if (e.max_step < e.dead_band)
    refuse({"exposure.dead_band", "exposure.max_step"},
           format_text("exposure.dead_band is %g, max_step %g", e.dead_band, e.max_step),
           "max_step at least as large as dead_band");
  if (e.exposure_min > e.exposure_start || e.exposure_start > e.exposure_max)
    refuse({"exposure.min_us", "exposure.start_us", "exposure.max_us"},
           format_text("exposure.min_us is %g, start_us %g, max_us %g", e.exposure_min.seconds() * 1e6,
                       e.exposure_start.seconds() * 1e6, e.exposure_max.seconds() * 1e6),
           "min_us not over start_us, and start_us not over max_us");
  if (e.gain_min > e.gain_max)
    refuse({"exposure.gain_min", "exposure.gain_max"},
           format_text("exposure.gain_min is %g, gain_max %g", e.gain_min, e.gain_max), "gain_min not over gain_max");
}

void check_together(const std::string& path, const app::FlightLoopConfig& c, const Lines& lines) {
  check_exposure(path, c.exposure, lines);
  const SpotSearchSettings& search = c.coop.search;
  if (!(search.range_min_m < search.range_max_m))
    throw InputError(
        path, last_line_of(lines, {"cooperative.range_min_m", "cooperative.range_max_m"}),
        format_text("cooperative.range_min_m is %g, range_max_m %g", search.range_min_m, search.range_max_m),
        "range_min_m under range_max_m");
  const InertiaRatios& inertia = c.navigator.filter.inertia;
  if (!inertia.is_physical())
    throw InputError(path, last_line_of(lines, {"filter.inertia_second", "filter.inertia_third"}),
                     format_text("filter.inertia_second is %g, inertia_third %g", inertia.second, inertia.third),
                     "moments of inertia, 1 among them, of which none is more than the other two together");
}

}  // namespace

void read_flight_config(const std::string& path, app::FlightLoopConfig& config) {
  const YAML::Node root = load_yaml(path, "a configuration in YAML");
  if (root.IsNull()) return;  // an empty file changes nothing
  const auto sections = sections_of(config);
  if (!root.IsMap()) throw InputError(path, 0, "holds no sections", names_of(sections));
  std::set<std::string> given;
  for (const auto& entry : root) {
    const std::string name = entry.first.Scalar();
    if (!given.insert(name).second)
      throw InputError(path, line_of(entry.first), "section " + in_quotes(name) + " a second time", "it once");
    if (!sections.contains(name)) {
      throw InputError(path, line_of(entry.first), "unknown section " + in_quotes(name),
                       "one of " + names_of(sections));
    }
  }
  read_flight_config(path, root, config);
}

void read_flight_config(const std::string& path, const YAML::Node& root, app::FlightLoopConfig& config) {
  const auto sections = sections_of(config);
  Lines lines;
  for (const auto& entry : root) {
    const std::string name = entry.first.Scalar();
    const auto section = sections.find(name);
    if (section != sections.end()) read_section(path, name, entry.second, section->second, lines);
  }
  check_together(path, config, lines);
}

std::vector<std::string> flight_config_sections() {
  app::FlightLoopConfig config;
  std::vector<std::string> names;
  for (const auto& [name, section] : sections_of(config)) names.push_back(name);
  return names;
}

}  // namespace relnav
