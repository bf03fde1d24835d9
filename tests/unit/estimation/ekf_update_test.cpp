#include "fsw/estimation/ekf_update.hpp"

#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>

#include "fsw/estimation/one_point_ransac.hpp"
#include "tests/support/dense.hpp"
#include "tests/unit/estimation/estimation_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

SparseRowPair random_rows(test::Samples& samples, const Feature& f) {
  SparseRowPair row;
  row.feature_offset = f.offset;
  row.feature_size = f.size;
  for (int r = 0; r < 2; ++r) {
    for (int k = 0; k < 6; ++k) row.motion[r][k] = samples.uniform(-1.0, 1.0);
    for (int k = 0; k < f.size; ++k) row.feature[r][k] = samples.uniform(-1.0, 1.0);
  }
  return row;
}

VectorXd states_of(const FilterState& state) {
  VectorXd x(state.size());
  x.head<12>() << state.motion.position, state.motion.attitude.parameters(), state.motion.velocity, state.motion.rate;
  for (const Feature& f : state.features()) x.segment(f.offset, f.size) = f.y.head(f.size);
  return x;
}

}  // namespace

TEST_GROUP(EkfUpdates) {
  // Not members: CppUTest's own new knows nothing of their alignment.
  std::unique_ptr<FilterState> state_memory = std::make_unique<FilterState>();
  std::unique_ptr<EkfUpdate> ekf_memory = std::make_unique<EkfUpdate>();
  FilterState& state = *state_memory;
  EkfUpdate& ekf = *ekf_memory;
  Innovations innovations;
  test::Samples samples{51};

  void set_up_state(AttitudeChartKind chart, int features) {
    state.reset(samples.motion(chart, 0.8), samples.covariance<12>(0.1));
    for (int i = 0; i < features; ++i) {
      CHECK(state.add(samples.feature(), samples.matrix<6, 12>(0.3), {}, samples.covariance<6>(0.1)).has_value());
    }
    if (features > 2) state.make_euclidean(1);
  }
  void set_up_innovations(double size) {
    innovations.clear();
    for (const Feature& f : state.features()) {
      Innovation i;
      i.H = random_rows(samples, f);
      i.nu_px = samples.matrix<2>(size);
      i.variance_px2 = samples.uniform(0.05, 0.3);
      CHECK(innovations.push_back(i) == Status::ok);
    }
  }
  MatrixXd dense_H() const {
    MatrixXd H(2 * static_cast<int>(innovations.size()), state.size());
    for (std::size_t i = 0; i < innovations.size(); ++i) {
      H.middleRows(2 * static_cast<int>(i), 2) = test::dense_rows(innovations[i].H, state.size());
    }
    return H;
  }
  MatrixXd dense_R() const {
    MatrixXd R = MatrixXd::Zero(2 * static_cast<int>(innovations.size()), 2 * static_cast<int>(innovations.size()));
    for (int k = 0; k < R.rows(); ++k) R(k, k) = innovations[static_cast<std::size_t>(k / 2)].variance_px2;
    return R;
  }
  VectorXd dense_nu() const {
    VectorXd nu(2 * static_cast<int>(innovations.size()));
    for (std::size_t i = 0; i < innovations.size(); ++i) nu.segment<2>(2 * static_cast<int>(i)) = innovations[i].nu_px;
    return nu;
  }
};

TEST(EkfUpdates, update_is_the_textbooks) {
  for (const AttitudeChartKind chart : test::both_charts) {
    for (const int features : {1, 7, 30}) {
      set_up_state(chart, features);
      set_up_innovations(1e-3);
      const MatrixXd P = test::dense_covariance(state);
      const MatrixXd H = dense_H();
      const MatrixXd R = dense_R();
      const VectorXd nu = dense_nu();
      const MatrixXd S = test::congruence(H, P) + R;
      const MatrixXd K = test::solve_symmetric(S, test::product(H, P)).transpose();
      const VectorXd x = states_of(state) + test::product(K, nu);
      const MatrixXd I_KH = MatrixXd::Identity(P.rows(), P.rows()) - test::product(K, H);
      const MatrixXd P_joseph = test::congruence(I_KH, P) + test::congruence(K, R);

      const UpdateResult result = ekf.apply(state, innovations);
      CHECK(result.status == Status::ok);
      LONGS_EQUAL(2 * features, result.rows);
      DOUBLES_EQUAL(test::mahalanobis_squared(nu, S), result.nis, 1e-9);
      CHECK(test::matrix_difference(test::dense_covariance(state), P_joseph) < 1e-11);
      VectorXd difference = states_of(state) - x;
      CHECK(difference.segment<3>(3).norm() < 1e-5);  // a rotation by A dp; the same as adding dp to first order
      difference.segment<3>(3).setZero();
      CHECK(difference.norm() < 1e-12);
    }
  }
}

TEST(EkfUpdates, one_innovations_step_is_the_textbooks_with_that_one_alone) {
  set_up_state(AttitudeChartKind::mrp, 9);
  set_up_innovations(0.5);
  const MatrixXd P = test::dense_covariance(state);
  ekf.prepare(state, innovations);
  for (std::size_t i = 0; i < innovations.size(); ++i) {
    const MatrixXd H = test::dense_rows(innovations[i].H, state.size());
    const MatrixXd S = test::congruence(H, P) + innovations[i].variance_px2 * MatrixXd::Identity(2, 2);
    const MatrixXd K = test::solve_symmetric(S, test::product(H, P)).transpose();
    const VectorXd expected = test::product(K, innovations[i].nu_px);
    VectorXd dx(state.size());
    CHECK(ekf.state_step(state, innovations, i, dx.data()) == Status::ok);
    CHECK(test::matrix_difference(dx, expected) < 1e-12);
  }
  CHECK(test::dense_covariance(state) == P);
}

TEST(EkfUpdates, nothing_to_update_with_changes_nothing) {
  set_up_state(AttitudeChartKind::mrp, 3);
  const MatrixXd P = test::dense_covariance(state);
  const VectorXd x = states_of(state);
  const UpdateResult result = ekf.apply(state, innovations);
  CHECK(result.status == Status::ok);
  LONGS_EQUAL(0, result.rows);
  CHECK(test::dense_covariance(state) == P && states_of(state) == x);
}

TEST(EkfUpdates, a_refused_update_leaves_the_state_as_it_was) {
  set_up_state(AttitudeChartKind::rodrigues, 5);
  for (const bool bad_noise : {true, false}) {
    set_up_innovations(0.1);
    if (bad_noise) {
      innovations[3].variance_px2 = -1e6;
    } else {
      innovations[3].nu_px(1) = std::numeric_limits<double>::quiet_NaN();
    }
    const MatrixXd P = test::dense_covariance(state);
    const VectorXd x = states_of(state);
    const UpdateResult result = ekf.apply(state, innovations);
    CHECK(result.status == (bad_noise ? Status::not_positive_definite : Status::not_finite));
    CHECK(test::dense_covariance(state) == P && states_of(state) == x);
  }
}

// ---- one-point RANSAC on a small scene: points before a camera whose motion is uncertain ------------------------------

namespace {

struct RansacScene {
  FilterState state;
  CompatibleMatches matches;
  Innovations innovations;
  EkfUpdate ekf;
  std::vector<bool> planted;
  CameraModel camera = test::sample_camera();
  RigidTargetMotion model;

  RansacScene(std::uint64_t seed, int features, double outlier_share) {
    test::Samples samples(seed);
    MotionState truth;
    truth.position = Vec3(0.0, 0.0, 5.0);
    truth.attitude = AttitudeState(AttitudeChartKind::mrp, samples.attitude(0.5));
    MotionState estimate = truth;
    estimate.position += samples.matrix<3>(0.05);
    estimate.attitude.rotate(samples.matrix<3>(0.01));
    state.reset(estimate, Mat12(1e-3 * Mat12::Identity()));
    const PoseLinearisation pose = model.pose(estimate);
    const PoseLinearisation true_pose = model.pose(truth);
    for (int i = 0; i < features; ++i) {
      Feature f;
      const Vec3 p_C = samples.within({-1.2, -1.0, 4.5}, {1.2, 1.0, 5.5});
      f.y.setZero();
      const Vec3 X_T = true_pose.R_CT.transpose() * (p_C - true_pose.t_CT);
      f.y.head<3>() = X_T - Vec3(0.0, 0.0, 2.0);
      f.y(5) = 0.5;
      CHECK(state.add(f, Mat<6, 12>::Zero(), {}, Mat6(1e-10 * Mat6::Identity())).has_value());
      CompatibleMatch m;
      m.feature = static_cast<std::size_t>(i);
      m.sigma_px = 0.3;
      CHECK(predict_pixel(camera, true_pose, state.features()[m.feature], m.uv_px) == Status::ok);
      const bool outlier = i < static_cast<int>(outlier_share * features);
      planted.push_back(outlier);
      // Each outlier goes its own way: they do not agree on another motion.
      m.uv_px +=
          outlier ? Vec2(15.0 * exp_so3(Vec3(0.0, 0.0, 2.4 * i)).block<2, 1>(0, 0)) : Vec2(samples.matrix<2>(0.15));
      Innovation innovation;
      PredictedImage image;
      CHECK(predict_image(camera, pose, state.features()[m.feature], image) == Status::ok);
      innovation.H = image.H;
      innovation.nu_px = m.uv_px - image.uv_px;
      innovation.variance_px2 = m.sigma_px * m.sigma_px;
      CHECK(matches.push_back(m) == Status::ok && innovations.push_back(innovation) == Status::ok);
    }
    ekf.prepare(state, innovations);
  }
  RansacResult run(std::uint64_t seed, const RansacConfig& settings = {}) const {
    Generator generator(seed);
    return one_point_ransac(settings, generator, camera, model, state, matches, innovations, ekf);
  }
};

}  // namespace

TEST_GROUP(OnePointRansac){};

TEST(OnePointRansac, finds_the_planted_outliers) {
  RansacConfig settings;
  settings.threshold_sigma = 10.0;  // one point leaves roll and range to others
  for (const double share : {0.0, 0.2, 0.4}) {
    int wrongly_in = 0;
    int wrongly_out = 0;
    constexpr int scenes = 20;
    for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
      const RansacScene scene(seed, 40, share);
      const RansacResult result = scene.run(seed, settings);
      int count = 0;
      for (std::size_t i = 0; i < scene.planted.size(); ++i) {
        if (result.inlier[i]) ++count;
        if (result.inlier[i] && scene.planted[i]) ++wrongly_in;
        if (!result.inlier[i] && !scene.planted[i]) ++wrongly_out;
      }
      LONGS_EQUAL(count, result.inliers);
    }
    std::printf("  one-point RANSAC, %2.0f %% outliers: %d of %d outliers in, %d inliers left to the rescue\n",
                100.0 * share, wrongly_in, static_cast<int>(share * 40) * scenes, wrongly_out);
    CHECK(wrongly_in <= static_cast<int>(share * 40) * scenes / 50);  // 2 %
    CHECK(wrongly_out <= 40 * scenes / 2);
  }
}

TEST(OnePointRansac, work_is_bounded_and_no_match_is_tried_twice) {
  RansacConfig settings;
  for (const int limit : {1, 5, 24, 1000}) {
    settings.max_hypotheses = limit;
    settings.threshold_sigma = 1e-9;  // nobody agrees: the worst case
    const RansacScene scene(3, 30, 0.4);
    const RansacResult result = scene.run(4, settings);
    LONGS_EQUAL(std::min(limit, 30), result.hypotheses);
  }
  settings = {};
  settings.threshold_sigma = 1e6;  // all agree: one hypothesis does
  LONGS_EQUAL(1, RansacScene(3, 30, 0.0).run(4, settings).hypotheses);
}

TEST(OnePointRansac, no_matches_give_no_inliers) {
  const RansacScene scene(3, 0, 0.0);
  const RansacResult result = scene.run(4);
  LONGS_EQUAL(0, result.inliers);
  LONGS_EQUAL(0, result.hypotheses);
}

TEST(OnePointRansac, same_seed_same_bits) {
  const RansacScene scene(5, 50, 0.4);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const RansacResult a = scene.run(seed);
    const RansacResult b = scene.run(seed);
    CHECK(a.inlier == b.inlier);
    LONGS_EQUAL(a.inliers, b.inliers);
    LONGS_EQUAL(a.hypotheses, b.hypotheses);
  }
}

}  // namespace relnav
