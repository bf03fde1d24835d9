#include "fsw/estimation/start_adjustment.hpp"

#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "tests/support/campaign.hpp"
#include "tests/support/dense.hpp"
#include "tests/unit/estimation/estimation_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

constexpr double frame_s = 0.1;

/// A turning body of points, seen without noise. T stands at the turning centre with C's axes at t = 0.
struct Scene {
  Vec3 c = Vec3(0.1, -0.05, 3.4);
  Vec3 v = Vec3::Zero();
  Vec3 omega = Vec3::Zero();
  std::vector<Vec3> points_T;
  std::vector<SlotHandle> slots;
  double half_extent = 0.25;

  /// bulge > 0: the middle is nearer than the rim.
  Scene(std::uint64_t seed, double bulge, int count = 30) {
    test::Samples samples(seed);
    for (int i = 0; i < count; ++i) {
      const double x = samples.uniform(-0.85, 0.85);
      const double y = samples.uniform(-0.85, 0.85);
      points_T.push_back({x, y, bulge * (x * x + y * y - 0.5) + samples.uniform(-0.05, 0.05)});
      slots.push_back({static_cast<std::uint16_t>(i), 3});
    }
  }
  Vec3 point_C(std::size_t i, double t_s) const { return exp_so3(Vec3(t_s * omega)) * points_T[i] + c + t_s * v; }
  static Vec2 image(const Vec3& p_C) { return p_C.head<2>() / p_C.z(); }

  StartAdjustment::Prior prior() const {
    StartAdjustment::Prior p;
    p.motion.c_C = c;
    p.motion.c_lateral_sigma_m = 0.5 * half_extent * c.z();
    p.motion.c_along_sigma_m = 0.125 * half_extent * half_extent * c.z();
    p.motion.v_sigma_m_s = 0.05 * c.z();
    p.motion.omega_sigma_rad_s = 3.0 * test::degree;
    p.motion.angular_psd = 0.1 * test::degree;
    p.rest_sigma_rad_s = 0.15 * test::degree;
    p.half_extent = half_extent;
    p.relief = half_extent;
    return p;
  }
  void add(StartAdjustment& start, std::size_t i, double t_s) const {
    const Vec2 xy = image(point_C(i, t_s));
    start.add_track(slots[i], t_s, Vec3(xy(0), xy(1), 1.0 / c.z()), 1e-5, half_extent / c.z());
  }
  void observe(StartAdjustment& start, double t_s, std::size_t count, double sigma) const {
    start.begin_frame(t_s);
    for (std::size_t i = 0; i < count; ++i) start.observe(slots[i], image(point_C(i, t_s)), sigma);
  }
};

StartAdjustment::Result adjusted(const Scene& scene, int frames, double sigma, std::size_t late = 0) {
  auto start = std::make_unique<StartAdjustment>();
  StartAdjustment::Result result;
  start->begin(scene.prior());
  const std::size_t first = scene.points_T.size() - late;
  for (std::size_t i = 0; i < first; ++i) scene.add(*start, i, 0.0);
  std::size_t count = first;
  for (int k = 1; k <= frames; ++k) {
    scene.observe(*start, frame_s * k, count, sigma);
    start->improve(2);
    CHECK(start->result(result) == Status::ok);
    if (k == frames / 2) {
      for (; count < scene.points_T.size(); ++count) scene.add(*start, count, frame_s * k);
    }
  }
  return result;
}

double greatest(const std::array<double, StartAdjustment::hypothesis_count>& weights) {
  return std::max(weights[0], std::max(weights[1], weights[2]));
}

}  // namespace

TEST_GROUP(StartAdjustments){};

TEST(StartAdjustments, recovers_rate_and_depths_of_noise_free_tracks) {
  const Vec3 rates_deg_s[] = {{1.0, -1.0, -2.0}, {0.0, 2.0, 0.0}, {-1.5, 1.0, 0.5}};
  for (const Vec3& rate_deg_s : rates_deg_s) {
    if (test::short_campaigns && &rate_deg_s != rates_deg_s) break;
    for (const double bulge : {0.5, -0.5}) {
      for (const std::size_t late : {0U, 6U}) {
        Scene scene(61, bulge);
        scene.omega = test::degree * rate_deg_s;
        scene.v = Vec3(0.01, -0.02, 0.01);
        const StartAdjustment::Result r = adjusted(scene, 60, 1e-5, late);
        const double rate_error = (r.theta.segment<3>(6) - scene.omega).norm() / test::degree;
        double depth_error = 0.0;
        // Scale is free: depths are compared relative to their mean ratio.
        double ratio = 0.0;
        std::vector<double> ratios;
        for (std::size_t i = 0; i < scene.points_T.size(); ++i) {
          const double t_s = i < scene.points_T.size() - late ? 0.0 : 0.1 * 30;
          ratios.push_back(1.0 / r.tracks[i].p(2) / scene.point_C(i, t_s).z());
          ratio += ratios.back() / static_cast<double>(scene.points_T.size());
        }
        for (const double q : ratios) depth_error = std::max(depth_error, std::fabs(q / ratio - 1.0));
        std::printf(
            "  start: bulge %4.1f, late %d: rate error %.4f deg/s, depth error %.4f, scale %.4f, weights %.3f %.3f "
            "%.3f\n",
            bulge, static_cast<int>(late), rate_error, depth_error, ratio, r.weights[0], r.weights[1], r.weights[2]);
        CHECK(rate_error < 0.05);
        CHECK(depth_error < 0.01);
      }
    }
  }
}

TEST(StartAdjustments, perspective_tells_a_target_from_its_mirror_image) {
  for (const double bulge : {0.6, -0.6}) {
    for (const double side : {1.0, -1.0}) {
      Scene scene(62, bulge);
      scene.omega = side * test::degree * Vec3(0.4, 2.0, 0.0);
      const StartAdjustment::Result r = adjusted(scene, 60, 3e-4);
      CHECK(r.theta.segment<3>(6).dot(scene.omega) > 0.0);
      CHECK(greatest(r.weights) > 0.99);
      double agreement = 0.0;  // relief the right way round
      for (std::size_t i = 0; i < scene.points_T.size(); ++i) {
        agreement += (1.0 / r.tracks[i].p(2) - scene.c.z()) * scene.points_T[i].z();
      }
      CHECK(agreement > 0.0);
    }
  }
}

TEST(StartAdjustments, the_wrong_sign_is_not_believed_because_it_settled_first) {
  for (const double bulge : {0.5, -0.5, 0.2, -0.2}) {
    for (const double side : {1.0, -1.0}) {
      Scene scene(66, bulge);
      scene.c.z() = 8.0;
      scene.half_extent = 0.11;
      scene.omega = side * test::degree * Vec3(0.1, 2.0, 0.0);
      for (int frames = 2; frames < 8; ++frames) {
        const StartAdjustment::Result r = adjusted(scene, frames, 3e-4);
        double wrong = 0.0;
        for (std::size_t i = 0; i < r.weights.size(); ++i) {
          if (r.thetas[i].segment<3>(6).dot(scene.omega) < 0.0) wrong += r.weights[i];
        }
        CHECK(wrong < 0.9);
      }
    }
  }
}

TEST(StartAdjustments, a_target_at_rest_is_found_at_rest_and_its_rate_known) {
  const Scene scene(63, 0.5);
  const StartAdjustment::Result r = adjusted(scene, 60, 3e-4);
  std::printf("  start at rest: weights %.3f %.3f %.3f\n", r.weights[0], r.weights[1], r.weights[2]);
  DOUBLES_EQUAL(1.0, r.weights[0] + r.weights[1] + r.weights[2], 1e-12);
  CHECK(r.weights[2] > 0.99);
  CHECK(r.theta.segment<3>(6).norm() < 0.05 * test::degree);
  CHECK(std::sqrt((r.covariance.block<3, 3>(6, 6).trace())) < 0.2 * test::degree);
}

TEST(StartAdjustments, a_short_look_at_a_slow_target_leaves_it_undecided) {
  Scene scene(68, 0.3);
  scene.omega = test::degree * Vec3(0.0, 0.6, 0.1);
  scene.c = Vec3(0.1, -0.05, 10.0);
  scene.half_extent = 0.085;
  const StartAdjustment::Result r = adjusted(scene, 10, 3e-4);
  std::printf("  short start: weights %.3f %.3f %.3f\n", r.weights[0], r.weights[1], r.weights[2]);
  CHECK(greatest(r.weights) < 0.99);
}

TEST(StartAdjustments, tracks_that_ended_still_tell_of_the_motion) {
  Scene scene(69, 0.5, 50);
  scene.omega = test::degree * Vec3(0.5, 2.0, 0.0);
  const auto rate_sigma = [&](bool ended_count) {
    auto start = std::make_unique<StartAdjustment>();
    auto result = std::make_unique<StartAdjustment::Result>();
    start->begin(scene.prior());
    for (std::size_t i = ended_count ? 0 : 25; i < 50; ++i) scene.add(*start, i, 0.0);
    for (int k = 1; k <= 30; ++k) {
      scene.observe(*start, frame_s * k, 50, 3e-4);
      start->improve(2);
      if (k == 20) {
        for (std::size_t i = 0; i < 25; ++i) start->end_track(scene.slots[i]);
      }
    }
    CHECK(start->result(*result) == Status::ok);
    CHECK_FALSE(start->has_track(scene.slots[3]));
    return std::sqrt((result->covariance.block<3, 3>(6, 6).trace()));
  };
  CHECK(rate_sigma(true) < 0.9 * rate_sigma(false));
}

TEST(StartAdjustments, covariances_are_positive_definite) {
  for (const double rate_deg_s : {0.0, 0.3, 3.0}) {
    Scene scene(64, 0.5);
    scene.omega = test::degree * rate_deg_s * Vec3(0.6, 0.0, 0.8);
    const StartAdjustment::Result r = adjusted(scene, 20, 3e-4);
    CHECK(r.covariance.allFinite());
    CHECK(test::matrix_difference(r.covariance, r.covariance.transpose()) < 1e-15);
    CHECK(test::eigenvalues_of(r.covariance).minCoeff() > 0.0);
    for (std::size_t i = 0; i < scene.points_T.size(); ++i) {
      CHECK(test::eigenvalues_of(r.tracks[i].covariance).minCoeff() > 0.0);
    }
  }
}

TEST(StartAdjustments, more_frames_than_keyframes_are_thinned_and_still_fit) {
  Scene scene(65, 0.5);
  scene.omega = test::degree * Vec3(0.0, 2.0, 0.5);
  const StartAdjustment::Result r = adjusted(scene, 150, 1e-5);
  CHECK((r.theta.segment<3>(6) - scene.omega).norm() < 0.05 * test::degree);
}

TEST(StartAdjustments, handles_that_are_not_its_own_are_ignored) {
  const Scene scene(66, 0.5);
  auto start = std::make_unique<StartAdjustment>();
  start->begin(scene.prior());
  start->observe(scene.slots[0], Vec2::Zero(), 1e-3);  // neither a frame nor a track yet
  scene.add(*start, 0, 0.0);
  CHECK(start->has_track(scene.slots[0]));
  SlotHandle stale = scene.slots[0];
  --stale.generation;
  CHECK_FALSE(start->has_track(stale));
  start->end_track(stale);
  CHECK(start->has_track(scene.slots[0]));

  // A wild observation under a stale handle does not matter.
  StartAdjustment::Result with;
  start->begin_frame(0.1);
  start->observe(stale, Vec2(0.7, 0.7), 1e-5);
  start->improve(2);
  CHECK(start->result(with) == Status::ok);
  CHECK(with.theta.head<3>() == scene.c);

  start->end_track(scene.slots[0]);
  CHECK_FALSE(start->has_track(scene.slots[0]));
  scene.add(*start, 0, 0.0);
  start->begin(scene.prior());
  CHECK_FALSE(start->has_track(scene.slots[0]));
  DOUBLES_EQUAL(0.0, start->span_s(), 0.0);
}

TEST(StartAdjustments, a_prior_without_spread_has_no_result) {
  Scene scene(67, 0.5);
  for (int what = 0; what < 4; ++what) {
    StartAdjustment::Prior prior = scene.prior();
    if (what == 0) prior.motion.c_lateral_sigma_m = 0.0;
    if (what == 1) prior.motion.v_sigma_m_s = 0.0;
    if (what == 2) prior.motion.omega_sigma_rad_s = prior.rest_sigma_rad_s = 0.0;
    if (what == 3) prior.motion.angular_psd = 0.0;
    auto start = std::make_unique<StartAdjustment>();
    start->begin(prior);
    for (std::size_t i = 0; i < scene.slots.size(); ++i) scene.add(*start, i, 0.0);
    scene.observe(*start, 0.1, scene.slots.size(), 1e-3);
    start->improve(2);
    StartAdjustment::Result result;
    const Status status = start->result(result);
    CHECK_TEXT(status != Status::ok, to_string(status));
  }
}

}  // namespace relnav
