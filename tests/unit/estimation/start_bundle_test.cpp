#include "fsw/estimation/start_bundle.hpp"

#include <cmath>
#include <limits>
#include <memory>

#include "tests/support/dense.hpp"
#include "tests/support/numeric_jacobian.hpp"
#include "tests/unit/estimation/estimation_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

constexpr double omega_sigma = 0.05;
constexpr double rho0 = 0.3;

StartBundle::Prior sample_prior() {
  StartBundle::Prior p;
  p.c_C = Vec3(0.1, -0.05, 1.0 / rho0);
  p.c_lateral_sigma_m = 0.4;
  p.c_along_sigma_m = 0.02;
  p.v_sigma_m_s = 0.2;
  p.omega_sigma_rad_s = omega_sigma;
  p.angular_psd = 0.002;
  return p;
}

SlotHandle slot_of(int i) { return {static_cast<std::uint16_t>(i), 1}; }

}  // namespace

TEST_GROUP(StartBundles) {
  std::unique_ptr<StartBundle> memory = std::make_unique<StartBundle>();
  StartBundle& bundle = *memory;
  std::unique_ptr<StartBundle::Normal> normal = std::make_unique<StartBundle::Normal>();
  std::unique_ptr<StartBundle::Points> points = std::make_unique<StartBundle::Points>();
  StartBundle::Points& p = *points;
  test::Samples samples{71};

  void setup() override { bundle.begin(sample_prior()); }
  Vec3 sample_point() {
    return {samples.uniform(-0.2, 0.2), samples.uniform(-0.2, 0.2), rho0 * samples.uniform(0.8, 1.25)};
  }
  StartBundle::Theta sample_theta() {
    StartBundle::Theta theta = samples.matrix<12>(0.05);
    theta.head<3>() += sample_prior().c_C;
    return theta;
  }
  void add(int i, double t_s) {
    const Vec3 first = sample_point();
    const std::size_t j = bundle.add_track(slot_of(i), t_s, first, 2e-4, 0.1);
    p[j] = first + samples.matrix<3>(0.01);
  }
  /// Every track in every frame, with errors from small to far outside the loss's scale.
  void observe(int tracks, double t_s) {
    bundle.begin_frame(t_s);
    for (int i = 0; i < tracks; ++i) {
      const std::size_t j = bundle.track_of(slot_of(i));
      if (j == StartBundle::max_tracks) continue;
      const Vec2 error = (i % 3 == 0 ? 3e-2 : 1e-3) * samples.matrix<2>();
      bundle.observe(slot_of(i), p[j].head<2>() + error, 5e-4);
    }
  }
};

TEST(StartBundles, right_hand_side_is_the_gradient_of_the_cost) {
  for (int i = 0; i < 8; ++i) add(i, 0.0);
  for (int k = 1; k <= 6; ++k) {
    if (k == 3) add(8, 0.25);  // one first seen later
    observe(9, 0.1 * k);
  }
  bundle.end_track(slot_of(2));  // and one that has ended
  const StartBundle::Theta theta = sample_theta();
  bundle.linearise(theta, p, omega_sigma, *normal);
  DOUBLES_EQUAL(bundle.cost_of(theta, p, omega_sigma), normal->cost, 1e-12 * normal->cost);

  const auto cost_by_theta = [&](const StartBundle::Theta& d) -> Mat<1> {
    return Mat<1>(bundle.cost_of(theta + d, p, omega_sigma));
  };
  const double scale = normal->b.norm();
  const Mat<1, 12> b = -normal->b.transpose() / scale;
  const auto scaled = [&](const StartBundle::Theta& d) -> Mat<1> { return cost_by_theta(d) / scale; };
  CHECK((test::jacobian_error<1, 12>(b, scaled, StartBundle::Theta::Zero(), 1e-6) < 1e-5));

  for (std::size_t j = 0; j < StartBundle::max_tracks; ++j) {
    if (!bundle.is_used(j)) continue;
    const double size = normal->g[j].norm();
    const auto cost_by_point = [&](const Vec3& d) -> Mat<1> {
      StartBundle::Points there = p;
      there[j] += d;
      return Mat<1>(bundle.cost_of(theta, there, omega_sigma) / size);
    };
    const Mat<1, 3> g = -normal->g[j].transpose() / size;
    CHECK((test::jacobian_error<1, 3>(g, cost_by_point, Vec3::Zero(), 1e-6) < 1e-5));
  }
}

TEST(StartBundles, solution_is_that_of_the_whole_system) {
  constexpr int tracks = 7;
  for (int i = 0; i < tracks; ++i) add(i, 0.0);
  for (int k = 1; k <= 5; ++k) observe(tracks, 0.1 * k);
  bundle.linearise(sample_theta(), p, omega_sigma, *normal);
  for (const double damping : {0.0, 1e-2, 10.0}) {
    const int n = 12 + 3 * tracks;
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd b(n);
    A.topLeftCorner(12, 12) = normal->A.selfadjointView<Eigen::Lower>();
    b.head(12) = normal->b;
    for (int i = 0; i < tracks; ++i) {
      const auto j = static_cast<std::size_t>(i);
      A.block(0, 12 + 3 * i, 12, 3) = normal->W[j];
      A.block(12 + 3 * i, 0, 3, 12) = normal->W[j].transpose();
      A.block(12 + 3 * i, 12 + 3 * i, 3, 3) = normal->H[j];
      b.segment(12 + 3 * i, 3) = normal->g[j];
    }
    A.diagonal() *= 1.0 + damping;
    const Eigen::VectorXd x = test::solve_symmetric(A, b);
    StartBundle::Theta d_theta;
    auto d_p = std::make_unique<StartBundle::Points>();
    CHECK(bundle.solve(*normal, damping, d_theta, *d_p));
    CHECK((d_theta - x.head(12)).norm() < 1e-9 * x.norm());
    for (int i = 0; i < tracks; ++i) {
      CHECK(((*d_p)[static_cast<std::size_t>(i)] - x.segment(12 + 3 * i, 3)).norm() < 1e-9 * x.norm());
    }
  }
}

TEST(StartBundles, a_point_behind_the_camera_costs_infinitely_much) {
  for (int i = 0; i < 4; ++i) add(i, 0.0);
  observe(4, 0.1);
  StartBundle::Theta theta = sample_theta();
  theta(5) = -200.0;  // the target flies through the camera
  CHECK(bundle.cost_of(theta, p, omega_sigma) == std::numeric_limits<double>::infinity());
  bundle.linearise(theta, p, omega_sigma, *normal);
  CHECK(normal->cost == std::numeric_limits<double>::infinity());
}

TEST(StartBundles, a_track_that_has_ended_counts_when_it_was_seen_often_enough) {
  for (int i = 0; i < 3; ++i) add(i, 0.0);
  observe(3, 0.1);
  observe(2, 0.2);
  observe(2, 0.3);
  const std::size_t often = bundle.track_of(slot_of(0));
  const std::size_t seldom = bundle.track_of(slot_of(2));
  bundle.end_track(slot_of(0));
  bundle.end_track(slot_of(2));
  CHECK(bundle.is_used(often));
  CHECK_FALSE(bundle.is_used(seldom));
  CHECK(bundle.track_of(slot_of(0)) == StartBundle::max_tracks);
  CHECK(bundle.track_in_slot(0) == StartBundle::max_tracks);
}

TEST(StartBundles, there_is_room_for_every_feature_however_many_have_ended) {
  constexpr int slots = static_cast<int>(config::max_features);
  for (int i = 0; i < slots; ++i) add(i, 0.0);
  double t_s = 0.0;
  for (int round = 0; round < 5; ++round) {
    for (int k = 0; k < 3; ++k) observe(slots, t_s += 0.1);
    for (int i = 0; i < slots; ++i) {
      bundle.end_track(slot_of(i));
      add(i, t_s);
      CHECK(bundle.track_of(slot_of(i)) < StartBundle::max_tracks);
    }
    for (int i = 1; i < slots; ++i) CHECK(bundle.track_of(slot_of(i)) != bundle.track_of(slot_of(i - 1)));
  }
  std::size_t used = 0;
  for (std::size_t j = 0; j < StartBundle::max_tracks; ++j) used += bundle.is_used(j) ? 1U : 0U;
  LONGS_EQUAL(StartBundle::max_tracks, used);
}

TEST(StartBundles, depths_of_all_tracks_together_are_known_as_one_would_be) {
  // Nothing observed yet: only priors. Twice the tracks, all off by the same depth, cost the same.
  const auto cost_of_common_offset = [&](int tracks) {
    bundle.begin(sample_prior());
    for (int i = 0; i < tracks; ++i) {
      const Vec3 first = sample_point();
      const std::size_t j = bundle.add_track(slot_of(i), 0.0, first, 2e-4, 0.1);
      p[j] = first + Vec3(0.0, 0.0, 0.05);
    }
    StartBundle::Theta at_prior = StartBundle::Theta::Zero();
    at_prior.head<3>() = sample_prior().c_C;
    return bundle.cost_of(at_prior, p, omega_sigma);
  };
  DOUBLES_EQUAL(0.125, cost_of_common_offset(1), 1e-12);
  DOUBLES_EQUAL(0.125, cost_of_common_offset(20), 1e-12);
}

TEST(StartBundles, a_depth_stays_near_its_prior) {
  const std::size_t j = bundle.add_track(slot_of(0), 0.0, Vec3(0.0, 0.0, rho0), 1e-3, 0.1);
  Vec3 point(0.3, 0.2, -1.0);
  bundle.clamp_depth(j, point);
  CHECK(point == Vec3(0.3, 0.2, 0.05 * rho0));
  point(2) = 100.0;
  bundle.clamp_depth(j, point);
  CHECK(point == Vec3(0.3, 0.2, 5.0 * rho0));
}

}  // namespace relnav
