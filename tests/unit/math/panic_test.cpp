// Sizes and offsets that do not fit are our own bugs: each kernel stops on each of them.
#include <array>
#include <limits>
#include <vector>

#include "fsw/math/covariance_kernels.hpp"
#include "tests/support/panics.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using test::panics;

TEST_GROUP(KernelPanic) {
  std::array<double, 32 * 32> numbers{};
  std::array<double, 4> four{};
  std::array<SparseRowPair, 2> two_pairs;
  [[nodiscard]] MatrixView matrix(int rows, int cols) { return {numbers.data(), rows, cols, 32}; }
  [[nodiscard]] std::span<double> elements(std::size_t count) { return std::span<double>(four).first(count); }
};

TEST(KernelPanic, StorageGivesNoMoreThanItHas) {
  MatrixStorage<6, 4> storage;
  const MatrixStorage<6, 4>& constant = storage;
  CHECK_TRUE(constant.view(6, 4).data == storage.view(6, 4).data);
  LONGS_EQUAL(storage.view(6, 4).ld, constant.view(0, 0).ld);
  constexpr std::array<std::array<int, 2>, 4> beyond{{{-1, 4}, {7, 4}, {6, -1}, {6, 5}}};
  for (const auto& [rows, cols] : beyond) {
    CHECK_TRUE(panics([&, r = rows, c = cols] { static_cast<void>(storage.view(r, c)); }));
    CHECK_TRUE(panics([&, r = rows, c = cols] { static_cast<void>(constant.view(r, c)); }));
  }
}

TEST(KernelPanic, ProductWithTheMeasurementRows) {
  const auto stops = [&](int rows, int cols, int product_rows, int product_cols) {
    return panics([&] { multiply_p_ht(matrix(rows, cols), two_pairs, matrix(product_rows, product_cols)); });
  };
  CHECK_FALSE(stops(12, 12, 12, 4));
  CHECK_TRUE(stops(12, 13, 12, 4));
  CHECK_TRUE(stops(11, 11, 11, 4));
  CHECK_TRUE(stops(12, 12, 13, 4));
  CHECK_TRUE(stops(12, 12, 12, 2));
}

TEST(KernelPanic, RowsWhoseFeatureIsNotInTheState) {
  const auto stops = [&](int offset, int size) {
    two_pairs[1].feature_offset = offset;
    two_pairs[1].feature_size = size;
    return panics([&] { multiply_p_ht(matrix(18, 18), two_pairs, matrix(18, 4)); });
  };
  CHECK_FALSE(stops(12, 6));
  CHECK_FALSE(stops(99, 0));
  CHECK_TRUE(stops(12, -1));
  CHECK_TRUE(stops(12, 7));
  CHECK_TRUE(stops(11, 6));
  CHECK_TRUE(stops(13, 6));
}

TEST(KernelPanic, InnovationCovariance) {
  const auto stops = [&](int cols, int rows_S, int cols_S, std::size_t variances) {
    return panics(
        [&] { innovation_covariance(two_pairs, matrix(12, cols), elements(variances), matrix(rows_S, cols_S)); });
  };
  CHECK_FALSE(stops(4, 4, 4, 4));
  CHECK_TRUE(stops(3, 4, 4, 4));
  CHECK_TRUE(stops(4, 5, 4, 4));
  CHECK_TRUE(stops(4, 4, 5, 4));
  CHECK_TRUE(stops(4, 4, 4, 3));
}

TEST(KernelPanic, TriangularFactors) {
  CHECK_FALSE(panics([&] { static_cast<void>(cholesky_lower(matrix(4, 4))); }));
  CHECK_TRUE(panics([&] { static_cast<void>(cholesky_lower(matrix(4, 3))); }));
  std::array<double, 32 * 4> others{};
  const MatrixView B{others.data(), 4, 4, 32};
  CHECK_FALSE(panics([&] { solve_right_transposed(matrix(4, 4), B); }));
  CHECK_TRUE(panics([&] { solve_right_transposed(matrix(4, 3), B); }));
  CHECK_TRUE(panics([&] { solve_right_transposed(matrix(3, 3), B); }));
  CHECK_FALSE(panics([&] { solve_lower(matrix(4, 4), elements(4)); }));
  CHECK_TRUE(panics([&] { solve_lower(matrix(4, 3), elements(4)); }));
  CHECK_TRUE(panics([&] { solve_lower(matrix(4, 4), elements(3)); }));
}

TEST(KernelPanic, IncrementAndCovariances) {
  std::array<double, 3> increment{};
  CHECK_FALSE(panics([&] { state_increment(matrix(3, 4), elements(4), increment); }));
  CHECK_TRUE(panics([&] { state_increment(matrix(3, 4), elements(3), increment); }));
  CHECK_TRUE(panics([&] { state_increment(matrix(4, 4), elements(4), increment); }));
  std::array<double, 32 * 4> others{};
  const ConstMatrixView B{others.data(), 4, 4, 32};
  CHECK_FALSE(panics([&] { downdate_symmetric(matrix(4, 4), B); }));
  CHECK_TRUE(panics([&] { downdate_symmetric(matrix(4, 5), B); }));
  CHECK_TRUE(panics([&] { downdate_symmetric(matrix(5, 5), B); }));
  CHECK_TRUE(panics([&] { mirror_lower(matrix(4, 5)); }));
}

TEST(KernelPanic, BlocksOutsideTheCovariance) {
  const Mat<motion_states, motion_states> F = Mat<motion_states, motion_states>::Identity();
  CHECK_FALSE(panics([&] { predict_motion(matrix(12, 12), F, F); }));
  CHECK_TRUE(panics([&] { predict_motion(matrix(12, 13), F, F); }));
  CHECK_TRUE(panics([&] { predict_motion(matrix(11, 11), F, F); }));
  const Mat3 J = Mat3::Identity();
  CHECK_FALSE(panics([&] { transform_block(matrix(6, 6), 3, J); }));
  CHECK_TRUE(panics([&] { transform_block(matrix(6, 7), 3, J); }));
  CHECK_TRUE(panics([&] { transform_block(matrix(6, 6), -1, J); }));
  CHECK_TRUE(panics([&] { transform_block(matrix(6, 6), 4, J); }));
}
