#pragma once
#include <cstdint>

#include "fsw/base/bounded_vector.hpp"
#include "fsw/base/slot_pool.hpp"
#include "fsw/config.hpp"
#include "fsw/estimation/motion_model.hpp"
#include "fsw/math/covariance_kernels.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

/// One tracked point: its block of the state, how it was first seen, and its record.
struct Feature {
  SlotHandle slot;
  int offset = 0;         ///< of its block in the state
  int size = 6;           ///< 6: inverse depth, 3: Euclidean point in T
  Vec6 y = Vec6::Zero();  ///< first `size` entries count

  // First sight, for the appearance prediction.
  Vec2 uv0_px = Vec2::Zero();
  Mat3 R_CT0 = Mat3::Identity();
  Vec3 r_TC0 = Vec3::Zero();

  std::uint32_t expected = 0;  ///< frames in which it was searched for
  std::uint32_t found = 0;     ///< of these, used in an update
  std::uint16_t lost_in_a_row = 0;
  std::uint16_t unseen_in_a_row = 0;  ///< frames outside the image or turned away
};

/// What the inverse depth of a new feature owes to one already in the state.
struct DepthTerm {
  int offset = 0;         ///< of that feature's block
  int size = 0;           ///< of it
  Vec6 J = Vec6::Zero();  ///< d rho / d block, first `size` entries
};
using DepthTerms = BoundedVector<DepthTerm, 4>;

/// The filter's state and covariance on preallocated storage: x = [motion (12) | feature blocks, without gaps].
/// Adding appends, removing and converting close the gap; nothing is ever allocated.
class FilterState {
 public:
  static constexpr int motion_size = static_cast<int>(config::motion_states);
  static constexpr int capacity = static_cast<int>(config::max_states);
  using Features = BoundedVector<Feature, config::max_features>;

  /// No features; covariance of the motion states as given.
  void reset(const MotionState& motion, const Mat12& P_motion);

  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] MatrixView P() { return P_.view(size_, size_); }
  [[nodiscard]] double P_at(int row, int col) const { return P_.view(capacity, capacity)(row, col); }
  [[nodiscard]] Features& features() { return features_; }
  [[nodiscard]] const Features& features() const { return features_; }
  /// nullptr when the handle is not in the state.
  [[nodiscard]] Feature* find(SlotHandle slot);
  [[nodiscard]] bool has_room() const { return !slots_.full(); }

  /// Appends an inverse-depth block. J_motion (6 x 12): its dependence on the motion states; depth_terms: that of its inverse
  /// depth on other features; noise: what comes on top.
  Expected<SlotHandle> add(const Feature& feature, const Mat<6, 12>& J_motion, const DepthTerms& depth_terms,
                           const Mat6& noise);
  /// Replaces motion and covariance and empties the state of feature blocks, keeping features() and their handles; each is
  /// then given its block again, in order, by restore(). For a restart from another estimate.
  void begin_restore(const MotionState& motion, const Mat12& P_motion);
  /// As add(), for the features()[index] that is kept; index counts up from 0.
  void restore(std::size_t index, const Vec6& y, const Mat<6, 12>& J_motion, const Mat6& noise);
  /// Removes a feature (position in features()) with its rows and columns.
  void remove(std::size_t index);
  /// Inverse depth -> Euclidean: state and covariance shrink by three, with the Jacobian of eq. (6).
  void make_euclidean(std::size_t index);
  /// x += dx over all blocks.
  void correct(const double* dx);
  /// Adds variance to a feature's position across the line of sight, as if the point itself had moved: sigma_m in
  /// both directions (Euclidean: in all three).
  void loosen(std::size_t index, double sigma_m);
  /// Every length times -1: position, velocity, anchors, points and inverse depths change sign, no image changes. Undoes a
  /// start that has taken the mirror image of the motion, with every depth negative.
  void negate_scale();
  /// Square blocks of the covariance as a small matrix.
  template <int Rows, int Cols>
  [[nodiscard]] Mat<Rows, Cols> P_block(int row, int col) const {
    Mat<Rows, Cols> block;
    for (int c = 0; c < Cols; ++c) {
      for (int r = 0; r < Rows; ++r) block(r, c) = P_at(row + r, col + c);
    }
    return block;
  }

  MotionState motion;

 private:
  [[nodiscard]] double& P_element(int row, int col) { return P_.view(capacity, capacity)(row, col); }
  void append_block(const Mat<6, 12>& J_motion, const DepthTerms& depth_terms, const Mat6& noise);
  void set_motion(const MotionState& motion, const Mat12& P_motion);
  /// Drops rows and columns first .. first + count - 1.
  void erase_states(int first, int count);

  SlotPool<config::max_features> slots_;
  Features features_;
  MatrixStorage<capacity, capacity> P_;
  int size_ = motion_size;
};

}  // namespace relnav
