#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "hil/dynamics/free_flight.hpp"
#include "hil/dynamics/jitter.hpp"
#include "hil/dynamics/rigid_body.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;

namespace {

Mat3 some_inertia() { return (Mat3() << 100.0, 5.0, -3.0, 5.0, 140.0, 8.0, -3.0, 8.0, 180.0).finished(); }
const Vec3 some_rate_T(0.02, 0.09, 0.03);  // rad/s

Time at_s(double seconds) { return Time{std::llround(seconds * 1e9)}; }

Vec3 momentum_I(const Mat3& inertia_T, const Turning& it) {
  return it.R_AB * inertia_T * it.R_AB.transpose() * it.omega_AB_A;
}

double energy(const Mat3& inertia_T, const Turning& it) { return 0.5 * it.omega_AB_A.dot(momentum_I(inertia_T, it)); }

/// RMS over seeds and axes.
template <typename Sample>
double rms(int seeds, const Sample& sample) {
  double sum = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) sum += Vec3(sample(static_cast<std::uint64_t>(seed))).squaredNorm();
  return std::sqrt(sum / (3.0 * seeds));
}

}  // namespace

TEST_GROUP(DynamicsRigidBody){};

TEST(DynamicsRigidBody, ASymmetricTopPrecesses) {
  // Goldstein, Classical Mechanics, 3rd ed., section 5.6: the axis goes round the momentum at H / J_t, and in the body
  // the rate goes round the axis at (J_t - J_a) / J_t omega_a against the sense of the spin of T about it.
  const double transverse = 100.0;
  const double axial = 160.0;
  const Mat3 inertia_T = Vec3(transverse, transverse, axial).asDiagonal();
  const Mat3 R_0 = rotation_of_angles(Vec3(10.0, -40.0, 70.0));
  const Vec3 omega_0_T(0.03, -0.05, 0.17);
  RigidBody body(inertia_T, R_0, omega_0_T, 0.0, 1);
  const Vec3 H_I = R_0 * inertia_T * omega_0_T;
  double largest = 0.0;
  double largest_rate = 0.0;
  for (double t = 0.0; t <= 1000.0; t += 12.345) {
    const double s = std::round(t * 1e9) * 1e-9;
    const Vec3 spin_T = Vec3::UnitZ() * (omega_0_T.z() * (transverse - axial) / transverse * s);
    const Mat3 R_IT = rotation_exp(H_I / transverse * s) * R_0 * rotation_exp(spin_T);
    const Vec3 omega_I = R_IT * (rotation_exp(spin_T).transpose() * omega_0_T);
    const Turning it = body.at(at_s(t));
    largest = std::max(largest, rotation_vector(it.R_AB * R_IT.transpose()).norm());
    largest_rate = std::max(largest_rate, (it.omega_AB_A - omega_I).norm());
  }
  CHECK(largest < 1e-12);
  CHECK(largest_rate < 1e-13);
}

TEST(DynamicsRigidBody, AGeneralTumbleKeepsEnergyAndMomentum) {
  RigidBody body(some_inertia(), Mat3::Identity(), some_rate_T, 0.0, 1);
  const Turning start = body.at(Time{0});
  double momentum_error = 0.0;
  double energy_error = 0.0;
  for (double t = 0.0; t <= 1000.0; t += 3.7) {
    const Turning it = body.at(at_s(t));
    const Vec3 change = momentum_I(some_inertia(), it) - momentum_I(some_inertia(), start);
    momentum_error = std::max(momentum_error, change.norm() / momentum_I(some_inertia(), start).norm());
    energy_error = std::max(energy_error, std::abs(energy(some_inertia(), it) / energy(some_inertia(), start) - 1.0));
  }
  CHECK(momentum_error < 1e-12);
  CHECK(energy_error < 1e-12);
}

TEST(DynamicsRigidBody, AFullTurnASecondKeepsItsMomentum) {
  RigidBody body(Vec3(100.0, 140.0, 180.0).asDiagonal(), Mat3::Identity(), Vec3(0.1, 2.0 * pi, 0.2), 0.0, 1);
  const Turning start = body.at(Time{0});
  const Turning end = body.at(at_s(100.0));
  const Mat3 inertia_T = Vec3(100.0, 140.0, 180.0).asDiagonal();
  DOUBLES_EQUAL(
      0.0, (momentum_I(inertia_T, end) - momentum_I(inertia_T, start)).norm() / momentum_I(inertia_T, start).norm(),
      1e-5);
}

TEST(DynamicsRigidBody, TheMiddleAxisIsUnstable) {
  // Louis Poinsot: a spin about the middle axis turns over, about the others it does not.
  const auto least_cosine = [](const Vec3& axis) {
    RigidBody body(Vec3(100.0, 140.0, 180.0).asDiagonal(), Mat3::Identity(), 0.1 * axis + Vec3::Constant(1e-4), 0.0, 1);
    double least = 1.0;
    for (double t = 0.0; t < 1000.0; t += 1.0) least = std::min(least, (body.at(at_s(t)).R_AB * axis).dot(axis));
    return least;
  };
  CHECK(least_cosine(Vec3::UnitX()) > 0.99);
  CHECK(least_cosine(Vec3::UnitY()) < -0.99);
  CHECK(least_cosine(Vec3::UnitZ()) > 0.99);
}

TEST(DynamicsRigidBody, RandomTorqueLetsTheRateWander) {
  const double density = 0.02;
  const double moment = 50.0;
  const auto change = [&](std::uint64_t seed) {
    RigidBody body(moment * Mat3::Identity(), Mat3::Identity(), Vec3::Zero(), density, seed);
    return body.at(at_s(100.0)).omega_AB_A;
  };
  DOUBLES_EQUAL(1.0, rms(200, change) / (density / moment * std::sqrt(100.0)), 0.12);  // 4 sigma of 600 samples
}

TEST(DynamicsRigidBody, RandomAccelerationLetsAVelocityWander) {
  const double density = 1e-3;
  const auto change = [&](std::uint64_t seed) {
    return FreeFlight(Gravity::none, {}, Time{0}, density, seed).at(at_s(100.0)).v_I;
  };
  DOUBLES_EQUAL(1.0, rms(200, change) / (density * std::sqrt(100.0)), 0.12);
}

TEST(DynamicsRigidBody, JitterHasTheSizeThatIsAskedForAndItsOwnRate) {
  const Jitter jitter({1e-3, 0.2}, 5);
  double sum = 0.0;
  int count = 0;
  for (double t = 0.0; t < 2000.0; t += 0.37) {
    sum += rotation_vector(jitter.at(t).R_AB).squaredNorm() / 3.0;
    ++count;
  }
  DOUBLES_EQUAL(1e-3, std::sqrt(sum / count), 2e-5);
  const double h = 1e-3;
  const Vec3 slope = rotation_vector(jitter.at(7.0 + h).R_AB * jitter.at(7.0 - h).R_AB.transpose()) / (2.0 * h);
  DOUBLES_EQUAL(0.0, (slope - jitter.at(7.0).omega_AB_A).norm(), 1e-9);
}

TEST(DynamicsRigidBody, ABlendOfTurningFramesHasItsOwnRate) {
  const auto at = [](double t) {
    const Turning a = turning_exp(Vec3(0.3, -0.2, 0.5) * t, Vec3(0.3, -0.2, 0.5));
    const Turning b = compose({rotation_of_angles(Vec3(20.0, 50.0, -30.0)), Vec3::Zero()},
                              turning_exp(Vec3(-0.1, 0.4, 0.2) * t, Vec3(-0.1, 0.4, 0.2)));
    return blend(a, b, 0.3 + 0.2 * t, 0.2);
  };
  const double h = 1e-3;
  const Vec3 slope = rotation_vector(at(0.5 + h).R_AB * at(0.5 - h).R_AB.transpose()) / (2.0 * h);
  DOUBLES_EQUAL(0.0, (slope - at(0.5).omega_AB_A).norm(), 1e-7);
}

TEST(DynamicsRigidBody, TimesDoNotGoBack) {
  RigidBody body(some_inertia(), Mat3::Identity(), some_rate_T, 0.0, 1);
  static_cast<void>(body.at(at_s(10.0)));
  CHECK(test::message_of([&] { static_cast<void>(body.at(at_s(9.0))); }) == "dynamics: time goes back");
}
