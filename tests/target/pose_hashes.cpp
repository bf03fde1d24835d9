/// Cooperative poses in each scalar, as hashes over all bits of the results: the same on every target, with an FPU or without.
/// Scenes from nothing but the generator, + - * / and sqrt.
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "fsw/attitude/quaternion.hpp"
#include "fsw/base/generator.hpp"
#include "fsw/estimation/scaled_motor_solver.hpp"
#include "fsw/estimation/scaled_pose_solver.hpp"

namespace {

using namespace relnav;

constexpr int poses = 24;

class Hash {  // FNV-1a
 public:
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(std::uint64_t bits) {
    for (int byte = 0; byte < 8; ++byte) {
      value_ = (value_ ^ ((bits >> (8 * byte)) & 0xFFU)) * 0x100000001B3ULL;
    }
  }
  void add(const Pose& pose) {
    for (int k = 0; k < 9; ++k) add(pose.R_CT(k / 3, k % 3));
    for (int k = 0; k < 3; ++k) add(pose.t_CT(k));
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325ULL;
};

class Scene {
 public:
  explicit Scene(std::size_t cameras) {
    CameraIntrinsics k{
        700.0, 705.0, 511.5, 511.5, 1024, 1024, DistortionModel::radial_tangential, {-0.05, 0.02, 0.0005, -0.0004}};
    for (std::size_t c = 0; c < cameras; ++c) {
      const auto camera = CameraModel::create(k);
      if (camera && rig.push_back({camera.value(), Mat3::Identity(), Vec3(-0.5 * static_cast<double>(c), 0.0, 0.0)}) !=
                        Status::ok) {
        return;
      }
    }
    for (std::uint16_t i = 0; i < 8; ++i) {
      const Vec3 p((i & 1U) != 0U ? 0.4 : -0.4, (i & 2U) != 0U ? 0.3 : -0.3, (i & 4U) != 0U ? 0.25 : -0.2);
      if (target.features.push_back({i, p, Vec3::Zero()}) != Status::ok) return;
    }
  }

  /// A new pose: any attitude in front of one camera, a moderate one before two.
  void draw() {
    const double turn = rig.size() == 1 ? 1.0 : 0.3;
    truth.R_CT = rotation(turn);
    // One draw a statement: the order of arguments is the compiler's.
    for (int k = 0; k < 3; ++k) truth.t_CT(k) = k < 2 ? between(-0.5, 0.5) : between(3.0, 9.0);
    start.R_CT = rotation(0.05) * truth.R_CT;
    start.t_CT = between(0.96, 1.04) * truth.t_CT;
    seen.clear();
    for (std::uint16_t c = 0; c < rig.size(); ++c) {
      for (std::uint16_t i = 0; i < target.features.size(); ++i) {
        Vec2 uv_px;
        const Vec3 p_C = truth.R_CT * target.features[i].p_T + truth.t_CT;
        if (rig[c].model.project(Vec3(p_C + rig[c].t_KC), uv_px) != Status::ok) continue;
        for (int k = 0; k < 2; ++k) uv_px(k) += between(-1.0, 1.0);
        if (seen.push_back({i, c, uv_px, 0.5}) != Status::ok) return;
      }
    }
  }

  CameraRig rig;
  TargetModel target;
  Pose truth;
  Pose start;
  PoseObservations seen;

 private:
  double between(double low, double high) { return low + (high - low) * generator_.uniform(); }
  Mat3 rotation(double turn) {
    const double x = between(-turn, turn);
    const double y = between(-turn, turn);
    const double z = between(-turn, turn);
    const double w = turn < 1.0 ? 1.0 : between(-1.0, 1.0);
    const double scale = 1.0 / std::sqrt(x * x + y * y + z * z + w * w);
    return Quaternion{scale * x, scale * y, scale * z, scale * w}.dcm();
  }

  Generator generator_{7};
};

void print(const char* name, const Hash& hash) {
  std::printf("%s %08lx%08lx\n", name, static_cast<unsigned long>(hash.value() >> 32U),
              static_cast<unsigned long>(hash.value() & 0xFFFFFFFFU));
}

ObservationMask all_used() {
  ObservationMask used;
  used.fill(true);
  return used;
}

/// `solve(scene, estimate)` over many poses.
template <typename Solve>
void run(const char* name, std::size_t cameras, Solve solve) {
  Scene scene(cameras);
  Hash hash;
  int solved = 0;
  for (int i = 0; i < poses; ++i) {
    scene.draw();
    PoseEstimate estimate;
    const Status status = solve(scene, estimate);
    hash.add(static_cast<std::uint64_t>(status));
    hash.add(estimate.pose);
    hash.add(estimate.chi2);
    if (status == Status::ok) ++solved;
  }
  std::printf("%d of %d ", solved, poses);
  print(name, hash);
}

template <typename S>
Status scaled(const Scene& scene, PoseEstimate& estimate) {
  return solve_scaled_pose<S>(scene.rig, scene.target, scene.seen, all_used(), scene.start, {}, estimate);
}

Status least_squares(const Scene& scene, PoseEstimate& estimate) {
  return solve_pose(scene.rig, scene.target, scene.seen, all_used(), scene.start, {}, estimate);
}

Status motor(const Scene& scene, PoseEstimate& estimate) {
  StereoPoints points;
  const Status status = triangulate_features(scene.rig, scene.target, scene.seen, points);
  return status == Status::ok ? solve_motor(scene.target, points, MotorLines::all, estimate.pose) : status;
}

template <typename S>
Status scaled_motor(const Scene& scene, PoseEstimate& estimate) {
  return solve_scaled_motor<S>(scene.rig, scene.target, scene.seen, MotorLines::all, estimate.pose);
}

}  // namespace

int main() {
  run("mono, least squares, double", 1, least_squares);
  run("mono, scaled, double", 1, scaled<double>);
  run("mono, scaled, float", 1, scaled<float>);
  run("mono, scaled, Q16.47", 1, scaled<FixedQ47>);
  run("stereo, least squares, double", 2, least_squares);
  run("stereo, scaled, Q16.47", 2, scaled<FixedQ47>);
  run("stereo, motor, double", 2, motor);
  run("stereo, motor, float", 2, scaled_motor<float>);
  run("stereo, motor, Q16.47", 2, scaled_motor<FixedQ47>);
  return 0;
}
