#include "hil/evaluate/evaluation.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "fsw/base/generator.hpp"
#include "hil/evaluate/chi_square.hpp"
#include "hil/evaluate/rotation.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::message_of;

namespace {

constexpr std::int64_t period_ns = 100'000'000;

/// A tumbling target on a curved way: position and attitude determine every alignment.
Trajectory tumbling_truth(int poses = 121) {
  Trajectory truth;
  const Vec3 omega_C(0.02, 0.05, -0.03);
  for (int i = 0; i < poses; ++i) {
    const double t = 0.1 * i;
    TimedPose pose;
    pose.time.ns = 100'000'000'000 + i * period_ns;
    pose.R_CT = rotation_exp(omega_C * t) * rotation_exp(Vec3(0.3, -0.2, 0.4));
    pose.t_CT = Vec3(0.3 * std::sin(0.4 * t), 0.2 * std::cos(0.3 * t), 8.0 - 0.2 * t);
    truth.push_back(pose);
  }
  return truth;
}

double gaussian(Generator& generator) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += generator.uniform();
  return sum;
}

}  // namespace

TEST_GROUP(ChiSquare){};

TEST(ChiSquare, QuantilesMatchTables) {
  // Abramowitz & Stegun, table 26.8.
  DOUBLES_EQUAL(3.841459, chi_square_quantile(0.95, 1), 1e-6);
  DOUBLES_EQUAL(1.237344, chi_square_quantile(0.025, 6), 1e-6);
  DOUBLES_EQUAL(14.449375, chi_square_quantile(0.975, 6), 1e-6);
  DOUBLES_EQUAL(124.342113, chi_square_quantile(0.95, 100), 1e-6);
  DOUBLES_EQUAL(0.95, chi_square_cdf(chi_square_quantile(0.95, 1800), 1800), 1e-10);
}

TEST_GROUP(AssociationOfStamps){};

TEST(AssociationOfStamps, MissingAndExtraEpochsAreCounted) {
  const Trajectory truth = tumbling_truth(10);
  Trajectory estimate = truth;
  estimate.erase(estimate.begin() + 3);
  estimate[0].time.ns -= 4'999'999;
  estimate[1].time.ns += 5'000'001;  // just too far
  const Association a = associate(truth, estimate);
  CHECK_EQUAL(8U, a.pairs.size());
  CHECK_EQUAL(2U, a.missing.size());
  CHECK_EQUAL(1U, a.missing[0]);
  CHECK_EQUAL(3U, a.missing[1]);
  CHECK_EQUAL(1U, a.estimates_without_truth);
}

TEST(AssociationOfStamps, ToleranceIsHalfTheShorterPeriod) {
  Trajectory truth = tumbling_truth(5);
  for (std::size_t i = 0; i < truth.size(); ++i) truth[i].time.ns = static_cast<std::int64_t>(i) * 4'000'000;
  Trajectory estimate = truth;
  for (TimedPose& pose : estimate) pose.time.ns += 3'000'000;  // nearer to the next one
  const Association a = associate(truth, estimate);
  CHECK_EQUAL(2'000'000, a.tolerance.ns);
  CHECK_EQUAL(1U, a.pairs[0].truth);
  CHECK_EQUAL(0U, a.pairs[0].estimate);
}

TEST_GROUP(EvaluationOfTrajectories) { Trajectory truth = tumbling_truth(); };

TEST(EvaluationOfTrajectories, IdentityHasNoError) {
  for (const AlignMode align : {AlignMode::none, AlignMode::se3, AlignMode::sim3, AlignMode::start}) {
    const Evaluation e = evaluate(truth, truth, nullptr, align);
    CHECK_EQUAL(truth.size(), e.epochs.size());
    DOUBLES_EQUAL(0.0, e.position.max, 1e-12);
    DOUBLES_EQUAL(0.0, e.attitude.max, 1e-12);
    DOUBLES_EQUAL(0.0, e.rate.max, 1e-12);
    DOUBLES_EQUAL(0.0, e.velocity.max, 1e-11);
  }
}

TEST(EvaluationOfTrajectories, PlantedErrorsKeepOrderAndSide) {
  const Vec3 dphi(0.01, -0.02, 0.03);
  const Vec3 dt(0.1, -0.2, 0.05);
  Trajectory estimate = truth;
  for (TimedPose& pose : estimate) {
    pose.R_CT = rotation_exp(-dphi) * pose.R_CT;  // R_true = Exp(dphi) R_est
    pose.t_CT -= dt;
  }
  const Evaluation e = evaluate(truth, estimate, nullptr, AlignMode::none);
  DOUBLES_EQUAL(0.0, (e.epochs[17].attitude - dphi).norm(), 1e-12);
  DOUBLES_EQUAL(0.0, (e.epochs[17].position - dt).norm(), 1e-12);
  DOUBLES_EQUAL(dphi.norm(), e.attitude.rms, 1e-12);
  DOUBLES_EQUAL(dt.norm(), e.position.max, 1e-12);
  DOUBLES_EQUAL(0.2, e.position.rms_axis.y(), 1e-12);
}

TEST(EvaluationOfTrajectories, RateErrorIsTheVectorDifference) {
  Trajectory estimate = truth;
  const Vec3 extra_C(0.0, 0.004, 0.0);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    // The truth turns about a fixed axis of C at 0.0616 rad/s; the estimate about another.
    const double t = 0.1 * static_cast<double>(i);
    estimate[i].R_CT = rotation_exp((Vec3(0.02, 0.05, -0.03) + extra_C) * t) * truth[0].R_CT;
  }
  const Evaluation e = evaluate(truth, estimate, nullptr, AlignMode::start);
  DOUBLES_EQUAL(1.0, e.rate_window.seconds(), 1e-12);
  CHECK_EQUAL(truth.size() - 10, e.rates.size());
  DOUBLES_EQUAL(0.004, e.rate.mean, 1e-9);
  DOUBLES_EQUAL(0.004, e.rate.max, 1e-9);
  DOUBLES_EQUAL(std::sqrt(0.0038), e.truth_mean_rate, 1e-9);
  DOUBLES_EQUAL(Vec3(0.02, 0.054, -0.03).norm(), e.estimate_mean_rate, 1e-9);
  DOUBLES_EQUAL(0.0038, e.truth_mean_rate * e.truth_mean_rate, 1e-9);
  DOUBLES_EQUAL(12.0 * std::sqrt(0.0038), e.angle_turned, 1e-9);
  DOUBLES_EQUAL(e.attitude.last, e.attitude.max, 1e-12);
}

TEST(EvaluationOfTrajectories, StartFindsScaleAndBodyPointInAFreeTargetFrame) {
  const double scale = 0.7;
  const Vec3 b_T(0.4, -0.3, 0.2);
  Trajectory estimate = truth;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    estimate[i].t_CT = (truth[i].t_CT + truth[i].R_CT * b_T) / scale;
    estimate[i].R_CT = truth[i].R_CT * truth[0].R_CT.transpose();  // axes of C at the first frame
  }
  const Evaluation e = evaluate(truth, estimate, nullptr, AlignMode::start);
  CHECK(e.body_point.has_value());
  CHECK_EQUAL(4, e.body_point->rank);
  DOUBLES_EQUAL(scale, e.body_point->scale, 1e-10);
  DOUBLES_EQUAL(0.0, (e.body_point->b_T - b_T).norm(), 1e-9);
  DOUBLES_EQUAL(0.0, e.position.max, 1e-9);
  DOUBLES_EQUAL(0.0, e.attitude.max, 1e-9);
}

TEST(EvaluationOfTrajectories, StartTakesTheMinimumNormWhenNothingMoves) {
  for (TimedPose& pose : truth) {
    pose.R_CT = truth[0].R_CT;
    pose.t_CT = Vec3(0.0, 0.0, 8.0);
  }
  Trajectory estimate = truth;
  for (TimedPose& pose : estimate) pose.t_CT *= 2.0;
  const Evaluation e = evaluate(truth, estimate, nullptr, AlignMode::start);
  CHECK_EQUAL(3, e.body_point->rank);
  DOUBLES_EQUAL(0.5, e.body_point->scale, 1e-12);
  DOUBLES_EQUAL(0.0, e.body_point->b_T.norm(), 1e-12);
  DOUBLES_EQUAL(0.0, e.position.max, 1e-12);
}

TEST(EvaluationOfTrajectories, Sim3FindsAPlantedSimilarity) {
  const Mat3 R = rotation_exp(Vec3(0.5, -1.0, 0.8));
  const Vec3 shift(3.0, -2.0, 1.0);
  const double scale = 2.5;
  Trajectory estimate = truth;
  for (TimedPose& pose : estimate) {
    const Vec3 centre = R.transpose() * (camera_centre(pose) - shift) / scale;
    pose.R_CT = pose.R_CT * R;
    pose.t_CT = -(pose.R_CT * centre);
  }
  const Evaluation e = evaluate(truth, estimate, nullptr, AlignMode::sim3);
  DOUBLES_EQUAL(scale, e.similarity->scale, 1e-9);
  DOUBLES_EQUAL(0.0, (e.similarity->R - R).norm(), 1e-9);
  DOUBLES_EQUAL(0.0, (e.similarity->t - shift).norm(), 1e-8);
  DOUBLES_EQUAL(0.0, e.position.max, 1e-9);
  DOUBLES_EQUAL(0.0, e.attitude.max, 1e-9);
  CHECK(evaluate(truth, estimate, nullptr, AlignMode::se3).position.rms > 0.1);  // the scale is off
}

TEST(EvaluationOfTrajectories, Sim3OnALineTakesTheRotationFromAttitudes) {
  for (std::size_t i = 0; i < truth.size(); ++i) {
    truth[i].R_CT.setIdentity();
    truth[i].t_CT = Vec3(0.0, 0.0, 10.0 - 0.05 * static_cast<double>(i));
  }
  Trajectory estimate = truth;
  const Mat3 roll = rotation_exp(Vec3(0.0, 0.0, 0.3));  // about the line: positions cannot tell
  for (TimedPose& pose : estimate) pose.R_CT = pose.R_CT * roll;
  const Evaluation e = evaluate(truth, estimate, nullptr, AlignMode::sim3);
  CHECK(e.similarity->rotation_from_attitudes);
  DOUBLES_EQUAL(0.0, e.attitude.max, 1e-9);
  DOUBLES_EQUAL(0.0, e.position.max, 1e-9);
}

TEST(EvaluationOfTrajectories, Sim3SeesThroughAMirroredSolution) {
  // Inverse depths of the wrong sign give a camera that moves backwards with the right attitudes; on a path near a line
  // half a turn about it hides that.
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double t = 0.1 * static_cast<double>(i);
    truth[i].R_CT = rotation_exp(Vec3(0.0, 0.02 * std::sin(t), 0.0));
    truth[i].t_CT = Vec3(t, 0.3 * std::sin(t), 5.0);
  }
  Trajectory estimate = truth;
  for (TimedPose& pose : estimate) pose.t_CT = -pose.t_CT;
  CHECK(!evaluate(truth, estimate, nullptr, AlignMode::sim3).position_rms_by_attitudes.has_value());
  const Evaluation good = evaluate(truth, truth, nullptr, AlignMode::sim3);
  DOUBLES_EQUAL(0.0, good.position_rms_by_attitudes.value(), 1e-9);
}

TEST(EvaluationOfTrajectories, NoCommonEpochIsAnError) {
  Trajectory estimate = truth;
  for (TimedPose& pose : estimate) pose.time.ns += 1'000'000'000'000;
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(evaluate(truth, estimate, nullptr, AlignMode::none)); }),
                      "no epoch in common");
}

TEST_GROUP(Nees) {
  Trajectory truth = tumbling_truth(400);
  Trajectory estimate = truth;
  std::vector<TimedCovariance> covariances;

  void setup() override {
    Generator generator(4);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      Mat6 A;
      for (int k = 0; k < 36; ++k) A(k / 6, k % 6) = gaussian(generator) * (k / 6 < 3 ? 0.02 : 0.004);
      Vec6 unit;
      for (int k = 0; k < 6; ++k) unit(k) = gaussian(generator);
      const Mat6 P = A * A.transpose() + Mat6::Identity() * 1e-9;
      const Vec6 error = A * unit;
      estimate[i].R_CT = rotation_exp(-error.tail<3>()) * truth[i].R_CT;
      estimate[i].t_CT = truth[i].t_CT - error.head<3>();
      covariances.push_back({truth[i].time, P});
    }
  }
};

TEST(Nees, ErrorsDrawnFromTheCovarianceLieInTheBand) {
  const Evaluation e = evaluate(truth, estimate, &covariances, AlignMode::none);
  CHECK(e.nees.has_value());
  CHECK_EQUAL(6, e.nees->degrees_of_freedom);
  CHECK_EQUAL(400U, e.nees->epochs);
  CHECK(e.nees->mean > e.nees->mean_low);
  CHECK(e.nees->mean < e.nees->mean_high);
  DOUBLES_EQUAL(0.95, e.nees->inside, 0.03);
}

TEST(Nees, OverconfidenceLeavesTheBand) {
  for (TimedCovariance& covariance : covariances) covariance.P /= 1.5;
  const Evaluation e = evaluate(truth, estimate, &covariances, AlignMode::none);
  CHECK(e.nees->mean > e.nees->mean_high);
}

TEST(Nees, OrderOfTheErrorStateMatters) {
  for (TimedCovariance& covariance : covariances) {
    Mat6 swapped;
    swapped << covariance.P.bottomRightCorner<3, 3>(), covariance.P.bottomLeftCorner<3, 3>(),
        covariance.P.topRightCorner<3, 3>(), covariance.P.topLeftCorner<3, 3>();
    covariance.P = swapped;
  }
  CHECK(evaluate(truth, estimate, &covariances, AlignMode::none).nees->mean > 20.0);
}

TEST(Nees, SimilarityCarriesTheCovarianceAlong) {
  // The same estimate in another target frame and scale: the NEES after alignment must not change.
  const Mat3 R = rotation_exp(Vec3(0.5, -1.0, 0.8));
  const Vec3 shift(3.0, -2.0, 1.0);
  constexpr double scale = 2.5;
  const double before = evaluate(truth, estimate, &covariances, AlignMode::sim3).nees->mean;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    TimedPose& pose = estimate[i];
    const Vec3 arm_C = pose.R_CT * shift;  // t_old = scale t_new - R_old shift
    pose.t_CT = (pose.t_CT + arm_C) / scale;
    pose.R_CT = pose.R_CT * R;
    Mat6 J = Mat6::Identity();
    J.topLeftCorner<3, 3>() /= scale;
    J.topRightCorner<3, 3>() = -cross_matrix(arm_C) / scale;
    covariances[i].P = (J * covariances[i].P * J.transpose()).eval();
  }
  const double after = evaluate(truth, estimate, &covariances, AlignMode::sim3).nees->mean;
  DOUBLES_EQUAL(before, after, 1e-5 * before);
}

TEST(Nees, StartJudgesTheAttitudeAlone) {
  // The first epoch without error pins the frame.
  estimate[0] = truth[0];
  const Evaluation e = evaluate(truth, estimate, &covariances, AlignMode::start);
  CHECK_EQUAL(3, e.nees->degrees_of_freedom);
  CHECK_EQUAL(399U, e.nees->epochs);
  CHECK(e.nees->mean > e.nees->mean_low);
  CHECK(e.nees->mean < e.nees->mean_high);
}

TEST(Nees, MissingAndSingularCovariancesAreCounted) {
  covariances[5].P.setZero();
  covariances.erase(covariances.begin() + 10);
  const Evaluation e = evaluate(truth, estimate, &covariances, AlignMode::none);
  CHECK_EQUAL(1U, e.nees->not_positive_definite);
  CHECK_EQUAL(1U, e.nees->without_covariance);
  CHECK_EQUAL(398U, e.nees->epochs);
}
