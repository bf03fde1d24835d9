#include "hil/replay/flight_config_file.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "hil/io/input_error.hpp"
#include "hil/io/text.hpp"
#include "hil/io/yaml_reader.hpp"

namespace relnav::hil {
namespace {

/// Takes a value; answers what was expected instead, or nothing when it is fine.
using Setter = std::function<std::string(const std::string& text)>;
using Section = std::map<std::string, Setter>;

Setter real(double& target) {
  return [&target](const std::string& text) -> std::string {
    const auto value = parse_double(text);
    if (!value || !std::isfinite(*value)) return "a finite number";
    target = *value;
    return {};
  };
}

template <typename Integer>
Setter whole(Integer& target) {
  return [&target](const std::string& text) -> std::string {
    const auto value = parse_int64(text);
    constexpr auto low = static_cast<std::int64_t>(std::numeric_limits<Integer>::min());
    constexpr auto high = std::numeric_limits<Integer>::digits >= 63
                              ? std::numeric_limits<std::int64_t>::max()
                              : static_cast<std::int64_t>(std::numeric_limits<Integer>::max());
    if (!value || *value < low || *value > high)
      return "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
    target = static_cast<Integer>(*value);
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

std::map<std::string, Section> sections_of(app::FlightLoopConfig& c) {
  NoncoopConfig& f = c.navigator.filter;
  return {
      {"filter",
       {{"chart", chart(f.chart)},
        {"inertia_second", real(f.inertia.second)},
        {"inertia_third", real(f.inertia.third)},
        {"inertia_phi_x_rad", real(f.inertia.phi_TP.x())},
        {"inertia_phi_y_rad", real(f.inertia.phi_TP.y())},
        {"inertia_phi_z_rad", real(f.inertia.phi_TP.z())},
        {"range_m", real(f.range_m)},
        {"range_sigma_m", real(f.range_sigma_m)},
        {"rate_sigma_rad_s", real(f.rate_sigma_rad_s)},
        {"velocity_sigma_per_range", real(f.velocity_sigma_per_range)},
        {"acceleration_psd_per_range", real(f.acceleration_psd_per_range)},
        {"angular_psd", real(f.angular_psd)},
        {"relief_per_extent", real(f.relief_per_extent)},
        {"min_relief", real(f.min_relief)},
        {"pixel_sigma_px", real(f.pixel_sigma_px)},
        {"first_view_sigma_px", real(f.first_view_sigma_px)},
        {"feature_walk_px2_per_deg", real(f.feature_walk_px2_per_deg)},
        {"robust_sigma", real(f.robust_sigma)},
        {"gate_chi2", real(f.gate_chi2)},
        {"linearity_threshold", real(f.linearity_threshold)},
        {"start_frames", whole(f.start_frames)},
        {"start_duration_s", real(f.start_duration_s)},
        {"start_angular_psd", real(f.start_angular_psd)},
        {"start_pixel_sigma_px", real(f.start_pixel_sigma_px)},
        {"rest_sigma_rad_s", real(f.rest_sigma_rad_s)},
        {"ransac_confidence", real(f.ransac.confidence)},
        {"ransac_threshold_sigma", real(f.ransac.threshold_sigma)},
        {"ransac_max_hypotheses", whole(f.ransac.max_hypotheses)},
        {"seed", whole(f.seed)}}},
      {"front_end",
       {{"fast_threshold", whole(c.navigator.fast_threshold)},
        {"min_start_features", whole(c.navigator.min_start_features)},
        {"min_score", real(c.navigator.tracker.min_score)},
        {"min_distance_px", real(c.navigator.spread.min_distance_px)},
        {"cell_px", whole(c.navigator.spread.cell_px)}}},
      {"cooperative",
       {{"expected_phi_x_rad", real(c.coop.phi_CT_expected.x())},
        {"expected_phi_y_rad", real(c.coop.phi_CT_expected.y())},
        {"expected_phi_z_rad", real(c.coop.phi_CT_expected.z())},
        {"expected_cone_rad", real(c.coop.expected_cone_rad)},
        {"min_observations", whole(c.coop.min_observations)},
        {"sensor_bits", whole(c.coop.sensor_bits)},
        {"gain_electrons_dn", real(c.coop.spots.gain_electrons_dn)},
        {"read_noise_dn", real(c.coop.spots.read_noise_dn)},
        {"psf_sigma_px", real(c.coop.spots.psf_sigma_px)},
        {"min_contrast", real(c.coop.spots.min_contrast)},
        {"max_area_px", whole(c.coop.spots.max_area_px)},
        {"max_elongation", real(c.coop.spots.max_elongation)},
        {"sigma_floor_px", real(c.coop.spots.sigma_floor_px)},
        {"model_sigma_px", real(c.coop.tracking.model_sigma_px)},
        {"flux_ratio", real(c.coop.tracking.flux_ratio)},
        {"range_min_m", real(c.coop.search.range_min_m)},
        {"range_max_m", real(c.coop.search.range_max_m)},
        {"max_hypotheses", whole(c.coop.search.max_hypotheses)},
        {"start_velocity_sigma_m_s", real(c.coop.filter.velocity_sigma_m_s)},
        {"start_rate_sigma_rad_s", real(c.coop.filter.rate_sigma_rad_s)},
        {"acceleration_psd", real(c.coop.filter.noise.acceleration_psd)},
        {"angular_psd", real(c.coop.filter.noise.angular_psd)},
        {"pair_tolerance_ns", whole(c.second.pair_tolerance.ns)}}},
      {"loop",
       {{"scale_known", yes_no(c.scale_known)},
        {"features_every_frames", whole(c.features_every_frames)},
        {"health_every_frames", whole(c.health_every_frames)},
        {"event_spacing_frames", whole(c.event_spacing_frames)},
        {"lost_after_frames", whole(c.lost_after_frames)},
        {"min_inliers", whole(c.min_inliers)},
        {"min_contrast", whole(c.frames.min_contrast)},
        {"refuse_frozen", yes_no(c.frames.refuse_frozen)},
        {"max_age_ns", whole(c.frames.max_age.ns)},
        {"apid_base", whole(c.packets.apid_base)}}},
  };
}

std::string names_of(const auto& map) {
  std::string names;
  for (const auto& [name, value] : map) names += (names.empty() ? "" : ", ") + name;
  return names;
}

void read_section(const std::string& path, const std::string& name, const YAML::Node& node, const Section& keys) {
  if (node.IsNull()) return;  // all defaults
  if (!node.IsMap())
    throw InputError(path, line_of(node), "section '" + name + "' holds no keys", "keys of " + names_of(keys));
  for (const auto& entry : node) {
    const std::string key = entry.first.Scalar();
    const auto setter = keys.find(key);
    if (setter == keys.end())
      throw InputError(path, line_of(entry.first), "unknown key " + quoted(name + "." + key),
                       "one of " + names_of(keys));
    const std::string expected = entry.second.IsScalar() ? setter->second(entry.second.Scalar()) : "a single value";
    if (!expected.empty()) {
      throw InputError(
          path, line_of(entry.first),
          name + "." + key + " is " + quoted(entry.second.IsScalar() ? entry.second.Scalar() : "a list or map"),
          expected);
    }
  }
}

}  // namespace

void read_flight_config(const std::string& path, app::FlightLoopConfig& config) {
  const auto sections = sections_of(config);
  const YAML::Node root = load_yaml(path, "a configuration in YAML");
  if (root.IsNull()) return;  // an empty file changes nothing
  if (!root.IsMap()) throw InputError(path, 0, "holds no sections", names_of(sections));
  for (const auto& entry : root) {
    const std::string name = entry.first.Scalar();
    const auto section = sections.find(name);
    if (section == sections.end())
      throw InputError(path, line_of(entry.first), "unknown section " + quoted(name), "one of " + names_of(sections));
    read_section(path, name, entry.second, section->second);
  }
}

}  // namespace relnav::hil
