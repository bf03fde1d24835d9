#include "fsw/app/config_image.hpp"

#include <concepts>
#include <type_traits>

#include "fsw/base/crc32.hpp"
#include "fsw/telemetry/byte_stream.hpp"

namespace relnav::app {
namespace {

constexpr std::uint32_t magic = 0x524E4346;  // RNCF
constexpr std::uint16_t version = 3;         // of the list of values below: a new one for every change
constexpr std::size_t header_bytes = 10;
constexpr std::size_t crc_bytes = 4;

class ValueWriter {
 public:
  explicit ValueWriter(telemetry::PacketWriter& out) : out_(out) {}
  void operator()(const double& value) { out_.f64(value); }
  template <typename T>
  requires std::integral<T> || std::is_enum_v<T>
  void operator()(const T& value) { out_.i64(static_cast<std::int64_t>(value)); }
  template <typename T, std::size_t Capacity>
  void size(const BoundedVector<T, Capacity>& list) {
    out_.u16(static_cast<std::uint16_t>(list.size()));
  }

 private:
  telemetry::PacketWriter& out_;
};

class ValueReader {
 public:
  explicit ValueReader(telemetry::PacketReader& in) : in_(in) {}
  void operator()(double& value) { value = in_.f64(); }
  template <typename T>
  requires std::integral<T> || std::is_enum_v<T>
  void operator()(T& value) {
    const std::int64_t read = in_.i64();
    value = static_cast<T>(read);
    if (static_cast<std::int64_t>(value) != read) fits_ = false;
  }
  template <typename T, std::size_t Capacity>
  void size(BoundedVector<T, Capacity>& list) {
    const std::size_t wanted = in_.u16();
    list.clear();
    for (std::size_t i = 0; i < wanted && fits_; ++i) fits_ = list.push_back(T()) == Status::ok;
  }
  [[nodiscard]] bool fits() const { return fits_; }

 private:
  telemetry::PacketReader& in_;
  bool fits_ = true;
};

// ---- The values, in the image's order. One list for both ways: `Config` is const when it is written. ----

template <typename Vector, typename Visit>
void visit_coordinates(Vector& vector, Visit& visit) {
  for (Eigen::Index i = 0; i < vector.size(); ++i) visit(vector(i));
}

template <typename Intrinsics, typename Visit>
void visit_camera(Intrinsics& c, Visit& visit) {
  visit(c.fu);
  visit(c.fv);
  visit(c.cu);
  visit(c.cv);
  visit(c.width_px);
  visit(c.height_px);
  visit(c.model);
  for (auto& coefficient : c.coefficients) visit(coefficient);
}

template <typename Config, typename Visit>
void visit_filter(Config& f, Visit& visit) {
  visit(f.motion);
  visit(f.chart);
  visit(f.inertia.second);
  visit(f.inertia.third);
  visit_coordinates(f.inertia.phi_TP, visit);
  visit(f.range_m);
  visit(f.range_sigma_m);
  visit(f.rate_sigma_rad_s);
  visit(f.velocity_sigma_per_range);
  visit(f.acceleration_psd_per_range);
  visit(f.angular_psd);
  visit(f.relief_per_extent);
  visit(f.min_relief);
  visit(f.pixel_sigma_px);
  visit(f.first_view_sigma_px);
  visit(f.feature_walk_px2_per_deg);
  visit(f.robust_sigma);
  visit(f.gate_chi2);
  visit(f.linearity_threshold);
  visit(f.start_frames);
  visit(f.start_duration_s);
  visit(f.start_angular_psd);
  visit(f.start_pixel_sigma_px);
  visit(f.rest_sigma_rad_s);
  visit(f.ransac.confidence);
  visit(f.ransac.threshold_sigma);
  visit(f.ransac.max_hypotheses);
  visit(f.seed);
}

template <typename Target, typename Visit>
void visit_target(Target& target, Visit& visit) {
  visit.size(target.features);
  for (auto& feature : target.features) {
    visit(feature.id);
    visit_coordinates(feature.p_T, visit);
    visit_coordinates(feature.normal_T, visit);
  }
  visit.size(target.lines);
  for (auto& line : target.lines) {
    visit(line.from);
    visit(line.to);
  }
}

template <typename Config, typename Visit>
void visit_cooperative(Config& c, Visit& visit) {
  visit_target(c.target, visit);
  visit_coordinates(c.phi_CT_expected, visit);
  visit(c.expected_cone_rad);
  visit(c.min_observations);
  visit(c.sensor_bits);
  visit(c.spots.gain_electrons_dn);
  visit(c.spots.read_noise_dn);
  visit(c.spots.psf_sigma_px);
  visit(c.spots.min_contrast);
  visit(c.spots.max_area_px);
  visit(c.spots.max_elongation);
  visit(c.spots.sigma_floor_px);
  visit(c.tracking.model_sigma_px);
  visit(c.tracking.flux_ratio);
  visit(c.search.range_min_m);
  visit(c.search.range_max_m);
  visit(c.search.max_hypotheses);
  visit(c.filter.velocity_sigma_m_s);
  visit(c.filter.rate_sigma_rad_s);
  visit(c.filter.noise.acceleration_psd);
  visit(c.filter.noise.angular_psd);
}

template <typename Lines, typename Visit>
void visit_lines(Lines& lines, Visit& visit) {
  visit(lines.heartbeat);
  visit(lines.pulse);
  visit(lines.exposure);
  visit(lines.time.tai_offset.ns);
  visit(lines.time.tolerance.ns);
  visit(lines.time.max_drift_ppb);
  visit(lines.time.drift_change_ppb);
  visit(lines.time.lock_pulses);
  visit(lines.time.restart_pulses);
  visit(lines.time.holdover_after.ns);
}

template <typename Exposure, typename Visit>
void visit_exposure(Exposure& e, Visit& visit) {
  visit(e.enabled);
  visit(e.brightness.sample_step_px);
  visit(e.brightness.dark_level);
  visit(e.brightness.bright_permille);
  visit(e.brightness.saturated_permille);
  visit(e.target_level);
  visit(e.ceiling_level);
  visit(e.black_level);
  visit(e.dead_band);
  visit(e.max_step);
  visit(e.settle_frames);
  visit(e.min_bright_samples);
  visit(e.dark_frames);
  visit(e.when_dark);
  visit(e.exposure_min.ns);
  visit(e.exposure_max.ns);
  visit(e.exposure_start.ns);
  visit(e.gain_min);
  visit(e.gain_max);
}

template <typename Config, typename Visit>
void visit_config(Config& c, Visit& visit) {
  visit(c.navigation);
  visit_camera(c.camera, visit);
  visit_camera(c.second.intrinsics, visit);
  visit_coordinates(c.second.R_C1C0, visit);  // column by column
  visit_coordinates(c.second.t_C1C0, visit);
  visit(c.second.pair_tolerance.ns);
  visit_filter(c.navigator.filter, visit);
  visit(c.navigator.fast_threshold);
  visit(c.navigator.min_start_features);
  visit(c.navigator.tracker.min_score);
  visit(c.navigator.spread.min_distance_px);
  visit(c.navigator.spread.cell_px);
  visit_cooperative(c.coop, visit);
  visit(c.scale_known);
  visit(c.features_every_frames);
  visit(c.health_every_frames);
  visit(c.event_spacing_frames);
  visit(c.lost_after_frames);
  visit(c.min_inliers);
  visit(c.frames.min_contrast);
  visit(c.frames.refuse_frozen);
  visit(c.frames.max_age.ns);
  visit(c.acquire_wait.ns);
  visit(c.packets.apid_base);
  visit_lines(c.lines, visit);
  visit_exposure(c.exposure, visit);
}

}  // namespace

Status write_config_image(const FlightLoopConfig& config, std::span<std::uint8_t> image, std::size_t& size) {
  if (image.size() < header_bytes + crc_bytes) return Status::no_capacity;
  telemetry::PacketWriter body(image.subspan(header_bytes, image.size() - header_bytes - crc_bytes));
  ValueWriter write(body);
  visit_config(config, write);
  if (body.status() != Status::ok) return body.status();
  telemetry::PacketWriter header(image);
  header.u32(magic);
  header.u16(version);
  header.u32(static_cast<std::uint32_t>(body.size()));
  const std::size_t covered = header_bytes + body.size();
  telemetry::PacketWriter(image.subspan(covered)).u32(crc32(image.first(covered)));
  size = covered + crc_bytes;
  return Status::ok;
}

Status read_config_image(std::span<const std::uint8_t> image, FlightLoopConfig& config) {
  telemetry::PacketReader header(image);
  if (header.u32() != magic || header.u16() != version) return Status::unsupported;
  const std::size_t body_bytes = header.u32();
  if (image.size() < header_bytes + crc_bytes || body_bytes != image.size() - header_bytes - crc_bytes) {
    return Status::incomplete;
  }
  const std::size_t covered = header_bytes + body_bytes;
  if (telemetry::PacketReader(image.subspan(covered)).u32() != crc32(image.first(covered))) return Status::crc_mismatch;
  telemetry::PacketReader body(image.subspan(header_bytes, body_bytes));
  FlightLoopConfig read;
  ValueReader values(body);
  visit_config(read, values);
  if (!values.fits() || body.status() != Status::ok || body.remaining() != 0) return Status::invalid_argument;
  config = read;
  return Status::ok;
}

}  // namespace relnav::app
