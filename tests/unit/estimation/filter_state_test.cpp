#include "fsw/estimation/filter_state.hpp"

#include <cmath>
#include <memory>
#include <vector>

#include "fsw/estimation/inverse_depth.hpp"
#include "tests/support/dense.hpp"
#include "tests/unit/estimation/estimation_samples.hpp"

#include <CppUTest/TestHarness.h>

namespace relnav {
namespace {

using Eigen::MatrixXd;
using test::congruence;

constexpr auto full_count = static_cast<int>(config::max_features);

/// Identity without rows first .. first + count - 1.
MatrixXd dropping(int size, int first, int count) {
  MatrixXd J = MatrixXd::Zero(size - count, size);
  for (int r = 0; r < size - count; ++r) J(r, r < first ? r : r + count) = 1.0;
  return J;
}

void check_blocks_are_without_gaps(const FilterState& state) {
  int offset = 12;
  for (const Feature& f : state.features()) {
    LONGS_EQUAL(offset, f.offset);
    offset += f.size;
  }
  LONGS_EQUAL(offset, state.size());
}

}  // namespace

TEST_GROUP(FilterStates) {
  // Not a member: CppUTest's own new knows nothing of its alignment.
  std::unique_ptr<FilterState> memory = std::make_unique<FilterState>();
  FilterState& state = *memory;
  test::Samples samples{41};

  void setup() override { state.reset(samples.motion(AttitudeChartKind::mrp, 0.8), samples.covariance<12>()); }
  SlotHandle add() {
    const Expected<SlotHandle> slot =
        state.add(samples.feature(), samples.matrix<6, 12>(), {}, samples.covariance<6>());
    CHECK(slot.has_value());
    return slot.value();
  }
};

TEST(FilterStates, adding_is_a_congruence_plus_noise) {
  for (int i = 0; i < 8; ++i) {
    const MatrixXd before = test::dense_covariance(state);
    const Mat<6, 12> J_motion = samples.matrix<6, 12>();
    const Mat6 noise = samples.covariance<6>();
    const int n = state.size();
    MatrixXd J = MatrixXd::Zero(n + 6, n);
    J.topRows(n).setIdentity();
    J.bottomLeftCorner(6, 12) = J_motion;
    // The inverse depth also depends on features that are there: none, one, ... as many as terms have room.
    DepthTerms terms;
    for (std::size_t k = 0; k < state.features().size() && !terms.full(); ++k) {
      const Feature& f = state.features()[k];
      const DepthTerm term{f.offset, f.size, samples.matrix<6>()};
      CHECK(terms.push_back(term) == Status::ok);
      J.block(n + 5, f.offset, 1, f.size) = term.J.head(f.size).transpose();
    }
    CHECK(state.add(samples.feature(), J_motion, terms, noise).has_value());
    MatrixXd expected = congruence(J, before);
    expected.bottomRightCorner(6, 6) += noise;
    CHECK(test::matrix_difference(test::dense_covariance(state), expected) < 1e-13);
    CHECK(test::dense_covariance(state) == test::dense_covariance(state).transpose());
    check_blocks_are_without_gaps(state);
    if (i == 2) state.make_euclidean(1);  // terms of both sizes from here on
  }
}

TEST(FilterStates, loosening_moves_a_point_across_its_line_of_sight) {
  for (const double distance_m : {0.8, 3.0, 12.0}) {
    state.reset(samples.motion(AttitudeChartKind::mrp, 0.8), samples.covariance<12>());
    add();
    state.features()[0].y << 0.1, 0.2, 0.3, 0.4, 0.0,
        1.0 / distance_m;  // elevation 0: angles are lengths over distance
    const double sigma_m = 0.05;
    const MatrixXd before = test::dense_covariance(state);
    const Feature f = state.features()[0];
    state.loosen(0, sigma_m);
    const MatrixXd added = test::dense_covariance(state) - before;
    Mat<3, 6> J;
    const Vec3 ray = (inverse_depth::point_T(f.y, J) - f.y.head<3>()).normalized();
    const Mat3 spread = J * added.block<6, 6>(12, 12) * J.transpose();
    CHECK(test::matrix_difference(spread, sigma_m * sigma_m * (Mat3::Identity() - ray * ray.transpose())) < 1e-12);
    CHECK((added.topLeftCorner<12, 12>().isZero(0.0)));

    state.make_euclidean(0);
    const MatrixXd euclidean_before = test::dense_covariance(state);
    state.loosen(0, sigma_m);
    const MatrixXd euclidean_added = test::dense_covariance(state) - euclidean_before;
    CHECK(test::matrix_difference(euclidean_added.block<3, 3>(12, 12), sigma_m * sigma_m * Mat3::Identity()) < 1e-10);
  }
}

TEST(FilterStates, removing_drops_rows_and_columns_and_nothing_else) {
  for (int i = 0; i < 7; ++i) add();
  state.make_euclidean(3);
  for (const std::size_t index : {2U, 0U, 4U, 1U, 1U, 1U, 0U}) {  // middle, first, last
    const MatrixXd before = test::dense_covariance(state);
    const Feature removed = state.features()[index];
    state.remove(index);
    const MatrixXd J = dropping(static_cast<int>(before.rows()), removed.offset, removed.size);
    CHECK(test::dense_covariance(state) == congruence(J, before));
    POINTERS_EQUAL(nullptr, state.find(removed.slot));
    check_blocks_are_without_gaps(state);
  }
  LONGS_EQUAL(12, state.size());
}

TEST(FilterStates, becoming_euclidean_is_the_congruence_of_eq_6) {
  for (int i = 0; i < 6; ++i) add();
  for (const std::size_t index : {5U, 0U, 2U}) {
    const MatrixXd before = test::dense_covariance(state);
    const Feature old = state.features()[index];
    Mat<3, 6> J_point;
    const Vec3 X = inverse_depth::point_T(old.y, J_point);
    state.make_euclidean(index);
    MatrixXd J = dropping(static_cast<int>(before.rows()), old.offset + 3, 3);
    J.block(old.offset, old.offset, 3, 6) = J_point;
    const MatrixXd after = test::dense_covariance(state);
    CHECK(test::matrix_difference(after, congruence(J, before)) < 1e-13);
    CHECK(after == after.transpose());
    LONGS_EQUAL(3, state.features()[index].size);
    CHECK(state.features()[index].slot == old.slot);
    CHECK((state.features()[index].y.head<3>() - X).norm() == 0.0);
    check_blocks_are_without_gaps(state);
  }
}

TEST(FilterStates, correction_reaches_every_block) {
  for (int i = 0; i < 3; ++i) add();
  state.make_euclidean(1);
  const FilterState before = state;
  std::vector<double> dx(static_cast<std::size_t>(state.size()));
  for (double& d : dx) d = samples.uniform(-1e-3, 1e-3);
  state.correct(dx.data());
  const Eigen::Map<const Eigen::VectorXd> d(dx.data(), state.size());
  CHECK((state.motion.position - before.motion.position - d.segment<3>(0)).norm() < 1e-15);
  CHECK((state.motion.attitude.parameters() - before.motion.attitude.parameters() - d.segment<3>(3)).norm() < 1e-15);
  CHECK((state.motion.velocity - before.motion.velocity - d.segment<3>(6)).norm() < 1e-15);
  CHECK((state.motion.rate - before.motion.rate - d.segment<3>(9)).norm() < 1e-15);
  for (std::size_t i = 0; i < 3; ++i) {
    const Feature& f = state.features()[i];
    for (int k = 0; k < f.size; ++k) DOUBLES_EQUAL(before.features()[i].y(k) + d(f.offset + k), f.y(k), 0.0);
  }
}

TEST(FilterStates, restoring_rebuilds_the_covariance_and_keeps_the_handles) {
  std::vector<SlotHandle> slots;
  for (int i = 0; i < 5; ++i) slots.push_back(add());
  state.make_euclidean(2);
  const Mat12 P0 = samples.covariance<12>();
  state.begin_restore(samples.motion(AttitudeChartKind::mrp, 0.2), P0);
  MatrixXd expected = P0;
  for (std::size_t i = 0; i < 5; ++i) {
    const Vec6 y = samples.feature().y;
    const Mat<6, 12> J_motion = samples.matrix<6, 12>();
    const Mat6 noise = samples.covariance<6>();
    state.restore(i, y, J_motion, noise);
    const auto n = expected.rows();
    MatrixXd J = MatrixXd::Zero(n + 6, n);
    J.topRows(n).setIdentity();
    J.bottomLeftCorner(6, 12) = J_motion;
    expected = congruence(J, expected);
    expected.bottomRightCorner(6, 6) += noise;
    CHECK(state.features()[i].y == y);
    CHECK(state.features()[i].slot == slots[i]);
  }
  CHECK(test::matrix_difference(test::dense_covariance(state), expected) < 1e-13);
  check_blocks_are_without_gaps(state);
}

TEST(FilterStates, a_full_pool_has_no_capacity_and_changes_nothing) {
  for (int i = 0; i < full_count; ++i) add();
  CHECK_FALSE(state.has_room());
  LONGS_EQUAL(FilterState::capacity, state.size());
  const MatrixXd before = test::dense_covariance(state);
  const Expected<SlotHandle> refused =
      state.add(samples.feature(), samples.matrix<6, 12>(), {}, samples.covariance<6>());
  CHECK(refused.status() == Status::no_capacity);
  LONGS_EQUAL(full_count, state.features().size());
  CHECK(test::dense_covariance(state) == before);
  state.remove(17);
  CHECK(state.has_room());
  add();
  LONGS_EQUAL(FilterState::capacity, state.size());
}

TEST(FilterStates, no_slot_leaks_however_often_features_come_and_go) {
  for (int round = 0; round < 300; ++round) {
    const std::uint32_t what = samples.generator().below(4);
    const auto count = static_cast<std::uint32_t>(state.features().size());
    if (what < 2 && state.has_room()) {
      add();
    } else if (what == 2 && count > 0) {
      state.remove(samples.generator().below(count));
    } else if (what == 3 && count > 0) {
      const std::size_t i = samples.generator().below(count);
      if (state.features()[i].size == 6) state.make_euclidean(i);
    }
    check_blocks_are_without_gaps(state);
  }
  while (!state.features().empty()) state.remove(0);
  LONGS_EQUAL(12, state.size());
  for (int i = 0; i < full_count; ++i) add();
  CHECK_FALSE(state.has_room());
}

TEST(FilterStates, a_handle_of_a_former_life_finds_nothing) {
  const SlotHandle removed = add();
  state.remove(0);
  const SlotHandle successor = add();
  LONGS_EQUAL(removed.index, successor.index);
  POINTERS_EQUAL(nullptr, state.find(removed));
  CHECK(state.find(successor) == &state.features()[0]);
  state.reset(state.motion, Mat12::Identity());
  POINTERS_EQUAL(nullptr, state.find(successor));
  const SlotHandle third = add();
  CHECK_FALSE(third == successor);
}

}  // namespace relnav
