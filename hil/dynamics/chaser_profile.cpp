#include "hil/dynamics/chaser_profile.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

namespace relnav::hil {
namespace {

/// Rate of change of the unit vector of `v`, which changes by `v_rate`.
Vec3 unit_rate(const Vec3& v, const Vec3& v_rate) {
  const Vec3 u = v.normalized();
  return (v_rate - u * u.dot(v_rate)) / v.norm();
}

double length_of(const StraightLeg& leg, const Vec3& from_L) {
  return leg.to_L ? (*leg.to_L - from_L).norm() : std::abs(from_L.norm() - leg.to_range_m);
}

Time later(Time time, double seconds) { return time + Duration{std::llround(seconds * 1e9)}; }

/// How long a leg lasts, and how its way is shared out.
PlannedPace planned_leg(const Leg& leg, const Vec3& from_L) {
  if (const auto* hold = std::get_if<HoldLeg>(&leg)) return {PaceKind::constant, hold->duration_s, 0.0};
  if (const auto* drift = std::get_if<DriftLeg>(&leg)) return {PaceKind::constant, drift->duration_s, 0.0};
  if (const auto* straight = std::get_if<StraightLeg>(&leg))
    return planned(straight->pace, length_of(*straight, from_L));
  if (const auto* circle = std::get_if<FlyAroundLeg>(&leg)) return planned(circle->pace, std::abs(circle->angle_rad));
  const CloseLeg& close = std::get<CloseLeg>(leg);
  return planned(close.pace, std::abs(from_L.norm() - close.to_range_m));
}

LocalState on_line(const Vec3& from_L, const Vec3& to_L, const LegProgress& done) {
  return {from_L + done.share * (to_L - from_L), done.rate * (to_L - from_L)};
}

LocalState on_circle(const FlyAroundLeg& leg, const Vec3& from_L, const LegProgress& done) {
  const Vec3 p_L = rotation_exp(leg.axis_L * (leg.angle_rad * done.share)) * from_L;
  return {p_L, (leg.angle_rad * done.rate) * leg.axis_L.cross(p_L)};
}

}  // namespace

Turning aimed_at_target(const LocalState& camera, const Vec3& down_L) {
  constexpr double least_sine = 0.0087;
  if (camera.p_L.norm() < 1e-6) throw std::domain_error("the camera is in the target's origin");
  const Vec3 z = -camera.p_L.normalized();
  const Vec3 side = down_L.cross(z);
  if (side.norm() < least_sine * down_L.norm()) throw std::domain_error("the line of sight runs along `down`");
  Mat3 R_LP;
  R_LP << side.normalized(), z.cross(side.normalized()), z;
  Mat3 rate;
  rate.col(2) = unit_rate(-camera.p_L, -camera.v_L);
  rate.col(0) = unit_rate(side, down_L.cross(rate.col(2)));
  rate.col(1) = rate.col(2).cross(R_LP.col(0)) + z.cross(rate.col(0));
  Vec3 omega_L = Vec3::Zero();  // of unit vectors e: half of the sum of e x de/dt
  for (int i = 0; i < 3; ++i) omega_L += 0.5 * R_LP.col(i).cross(rate.col(i));
  return {R_LP, omega_L};
}

ChaserProfile::ChaserProfile(const ChaserSettings& settings, ReferenceOrbit& orbit, std::uint64_t seed)
    : settings_(settings), seed_(seed), from_{settings.start_L, Vec3::Zero()} {
  if (settings_.legs.empty()) settings_.legs.emplace_back(HoldLeg{});
  R_LC_fixed_ = aimed_at_target(from_, settings_.down_L).R_AB * settings_.R_PC;
  begin_leg(Time{0}, orbit);
}

void ChaserProfile::begin_leg(Time time, ReferenceOrbit& orbit) {
  const Leg& leg = settings_.legs[leg_];
  leg_start_ = time;
  pace_ = planned_leg(leg, docking_m_ ? Vec3(0.0, 0.0, *docking_m_) : from_.p_L);
  leg_end_ = later(time, pace_.duration_s);
  flight_.reset();
  if (const auto* drift = std::get_if<DriftLeg>(&leg)) {
    if (drift->velocity_L) from_.v_L = *drift->velocity_L;
    const ReferenceOrbit::Now now = orbit.at(time);
    flight_.emplace(orbit.gravity(), inertial_state(from_, now.state, now.il), time, drift->acceleration_density,
                    seed_ + leg_);
  }
}

void ChaserProfile::advance(Time time, ReferenceOrbit& orbit) {
  while (leg_ + 1 < settings_.legs.size() && time >= leg_end_) {
    if (const auto* close = std::get_if<CloseLeg>(&settings_.legs[leg_])) {
      docking_m_ = close->to_range_m;
    } else if (!docking_m_) {
      from_ = left_behind(orbit.at(leg_end_));
    }
    ++leg_;
    begin_leg(leg_end_, orbit);
  }
}

LocalState ChaserProfile::left_behind(const ReferenceOrbit::Now& target) {
  LocalState end = place(leg_end_, target);
  // At its very end a leg is at rest; with a constant pace it has been moving until then.
  if (!flight_ && pace_.kind == PaceKind::constant) end.v_L = place(leg_end_ + Duration{-1}, target).v_L;
  return end;
}

LocalState ChaserProfile::place(Time time, const ReferenceOrbit::Now& target) {
  const Leg& leg = settings_.legs[leg_];
  if (flight_) return local_state(flight_->at(time), target.state, target.il);
  const LegProgress done = progress(pace_, (time - leg_start_).seconds());
  if (const auto* straight = std::get_if<StraightLeg>(&leg)) {
    return on_line(from_.p_L, straight->to_L ? *straight->to_L : from_.p_L.normalized() * straight->to_range_m, done);
  }
  if (const auto* circle = std::get_if<FlyAroundLeg>(&leg)) return on_circle(*circle, from_.p_L, done);
  return {from_.p_L, Vec3::Zero()};
}

Turning ChaserProfile::aim(const LocalState& camera) const {
  if (!settings_.follows_target) return {R_LC_fixed_, Vec3::Zero()};
  return compose(aimed_at_target(camera, settings_.down_L), {settings_.R_PC, Vec3::Zero()});
}

CameraMotion ChaserProfile::closing(double t_s, const Turning& lt) const {
  const auto* close = std::get_if<CloseLeg>(&settings_.legs[leg_]);
  const LegProgress done = progress(pace_, t_s);
  if (docking_m_) {
    const double to_m = close != nullptr ? close->to_range_m : *docking_m_;
    const Vec3 p_T(0.0, 0.0, -(*docking_m_ + done.share * (to_m - *docking_m_)));
    const Vec3 v_T(0.0, 0.0, -done.rate * (to_m - *docking_m_));
    return {{lt.R_AB * p_T, lt.R_AB * v_T + lt.omega_AB_A.cross(lt.R_AB * p_T)}, lt};
  }
  // From rest in L into the target's own motion, both weighted: speed stays continuous when the target turns.
  const Vec3 goal_L = lt.R_AB * Vec3(0.0, 0.0, -close->to_range_m);
  LocalState camera = on_line(from_.p_L, goal_L, done);
  camera.v_L += done.share * lt.omega_AB_A.cross(goal_L);
  return {camera, blend(aim(camera), lt, done.share, done.rate)};
}

CameraMotion ChaserProfile::at(Time time, const ReferenceOrbit::Now& target, const Turning& lt) {
  if (docking_m_ || std::holds_alternative<CloseLeg>(settings_.legs[leg_])) {
    return closing((time - leg_start_).seconds(), lt);
  }
  const LocalState camera = place(time, target);
  return {camera, aim(camera)};
}

}  // namespace relnav::hil
