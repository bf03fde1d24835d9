#include "fsw/app/telemetry_writer.hpp"

#include <cmath>

#include "fsw/attitude/quaternion.hpp"
#include "fsw/telemetry/byte_stream.hpp"

namespace relnav::app {
namespace {

/// Row-major upper triangle. False when a number does not fit a float.
bool upper_triangle(const Mat6& P, std::array<float, 21>& out) {
  std::size_t k = 0;
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) {
      out[k] = static_cast<float>(P(r, c));
      if (!telemetry::is_finite(out[k])) return false;
      ++k;
    }
  }
  return true;
}

void copy(const Vec3& from, std::array<double, 3>& to) { to = {from.x(), from.y(), from.z()}; }

/// Inliers of the features searched for, percent.
std::uint8_t quality_of(const StepReport& report) {
  unsigned searched = 0;
  unsigned used = 0;
  for (const FeatureReport& f : report.feature_reports) {
    if (f.use == FeatureUse::not_expected || f.use == FeatureUse::added) continue;
    ++searched;
    if (f.use == FeatureUse::low_innovation || f.use == FeatureUse::high_innovation) ++used;
  }
  return searched > 0 ? static_cast<std::uint8_t>(100U * used / searched) : std::uint8_t{0};
}

bool is_measured(FeatureUse use) { return use != FeatureUse::not_expected && use != FeatureUse::not_found; }

}  // namespace

Status TelemetryWriter::configure(const telemetry::PacketConfig& config, std::uint32_t event_spacing_frames) {
  const Status status = context_.configure(config);
  if (status != Status::ok) return status;
  events_.configure(event_spacing_frames);
  dropped_ = 0;
  return Status::ok;
}

template <typename Packet>
void TelemetryWriter::send(const Packet& packet) {
  const Expected<std::size_t> size = telemetry::encode(packet, context_, buffer_);
  if (!size || link_.send({buffer_.data(), size.value()}) != Status::ok) {
    if (dropped_ < 0xFFFFFFFFU) ++dropped_;
  }
}

void TelemetryWriter::send_state(const StepReport& report, const FrameStamp& stamp, const StateValidity& validity) {
  using telemetry::RelStatePacket;
  RelStatePacket p;
  p.time_ns = static_cast<std::uint64_t>(stamp.time.ns);
  p.frame_sequence = stamp.sequence;
  p.camera = report.camera;
  p.mode = static_cast<std::uint8_t>(report.mode);
  p.reset_counter = static_cast<std::uint16_t>(report.reset_counter & 0xFFFFU);
  if (validity.estimate) {
    const RelativeState& s = report.state;
    p.estimator = static_cast<std::uint8_t>(report.estimator);
    p.quality = quality_of(report);
    p.valid_flags = telemetry::valid::pose | telemetry::valid::velocity | telemetry::valid::rate;
    if (validity.scale_known) p.valid_flags |= telemetry::valid::scale;
    if (validity.predicted) p.valid_flags |= telemetry::valid::predicted;
    copy(s.t_CT, p.t_CT);
    const Quaternion q = Quaternion::from_dcm(s.R_CT).canonical();
    p.q_CT = {q.x, q.y, q.z, q.w};
    copy(s.v_C, p.v_C);
    copy(s.omega_C, p.omega_C);
    if (upper_triangle(s.pose_covariance, p.pose_covariance)) {
      p.valid_flags |= telemetry::valid::pose_covariance;
    } else {
      p.pose_covariance = {};
    }
    if (upper_triangle(s.rate_covariance, p.rate_covariance)) {
      p.valid_flags |= telemetry::valid::rate_covariance;
    } else {
      p.rate_covariance = {};
    }
  }
  send(p);
}

void TelemetryWriter::send_features(const StepReport& report, const FrameStamp& stamp) {
  constexpr std::size_t per_packet = telemetry::max_features_per_packet;
  const std::size_t total = report.feature_reports.size();
  const std::size_t parts = total == 0 ? 1 : (total + per_packet - 1) / per_packet;
  features_.time_ns = static_cast<std::uint64_t>(stamp.time.ns);
  features_.frame_sequence = stamp.sequence;
  features_.parts = static_cast<std::uint8_t>(parts);
  features_.features_total = static_cast<std::uint16_t>(total);
  for (std::size_t part = 0; part < parts; ++part) {
    features_.part = static_cast<std::uint8_t>(part);
    features_.entries.clear();
    for (std::size_t i = part * per_packet; i < total && !features_.entries.full(); ++i) {
      const FeatureReport& f = report.feature_reports[i];
      const bool measured = is_measured(f.use);
      const Vec2& uv_px = measured ? f.measured_px : f.predicted_px;
      telemetry::FeatureEntry entry;
      entry.slot = f.index;
      entry.generation = f.generation;
      entry.u_px_256 = telemetry::to_px_256(uv_px(0));
      entry.v_px_256 = telemetry::to_px_256(uv_px(1));
      entry.use = static_cast<std::uint8_t>(f.use);
      const float residual = measured ? static_cast<float>((f.measured_px - f.predicted_px).norm()) : 0.0F;
      entry.residual_px = telemetry::is_finite(residual) ? residual : 0.0F;
      if (features_.entries.push_back(entry) != Status::ok) break;
    }
    send(features_);
  }
}

void TelemetryWriter::send_health(telemetry::HealthPacket packet) {
  packet.telemetry_dropped = dropped_;
  packet.event_count = events_.count();
  packet.events_suppressed = events_.suppressed();
  if (!telemetry::is_finite(packet.test_ratio)) packet.test_ratio = 0.0F;
  send(packet);
}

void TelemetryWriter::send_time(const telemetry::TimePacket& packet) { send(packet); }
void TelemetryWriter::send_command_ack(const telemetry::CommandAckPacket& packet) { send(packet); }
void TelemetryWriter::send_pong(const telemetry::PongPacket& packet) { send(packet); }

void TelemetryWriter::send_event(telemetry::EventId id, Status status, const FrameStamp& stamp, std::uint32_t frame,
                                 const EventArgs& args, std::size_t camera) {
  telemetry::EventPacket p;
  if (!events_.note(id, frame, p, camera)) return;
  p.status = static_cast<std::uint8_t>(status);
  p.time_ns = static_cast<std::uint64_t>(stamp.time.ns);
  p.frame_sequence = stamp.sequence;
  p.args = args;
  send(p);
}

}  // namespace relnav::app
