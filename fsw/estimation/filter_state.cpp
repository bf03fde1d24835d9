#include "fsw/estimation/filter_state.hpp"

#include "fsw/estimation/inverse_depth.hpp"

namespace relnav {

void FilterState::set_motion(const MotionState& start, const Mat12& P_motion) {
  motion = start;
  motion_lin = start;
  size_ = motion_size;
  for (int c = 0; c < motion_size; ++c) {
    for (int r = 0; r < motion_size; ++r) P_element(r, c) = P_motion(r, c);
  }
}

void FilterState::reset(const MotionState& start, const Mat12& P_motion) {
  // Every handle goes stale, so that a patch of the former life cannot be taken for one of the new.
  for (const Feature& f : features_) RELNAV_ASSERT(slots_.release(f.slot) == Status::ok);
  features_.clear();
  set_motion(start, P_motion);
}

void FilterState::begin_restore(const MotionState& start, const Mat12& P_motion) { set_motion(start, P_motion); }

void FilterState::restore(std::size_t index, const Vec6& y, const Mat<6, 12>& J_motion, const Mat6& noise) {
  Feature& f = features_[index];
  f.offset = size_;
  f.size = 6;
  f.y = y;
  f.y_lin = y;
  append_block(J_motion, noise);
}

Feature* FilterState::find(SlotHandle slot) {
  for (Feature& f : features_) {
    if (f.slot == slot) return &f;
  }
  return nullptr;
}

Expected<SlotHandle> FilterState::add(const Feature& feature, const Mat<6, 12>& J_motion, const Mat6& noise) {
  const Expected<SlotHandle> slot = slots_.acquire();
  if (!slot) return slot.status();
  Feature added = feature;
  added.slot = slot.value();
  added.offset = size_;
  added.size = 6;
  RELNAV_ASSERT(features_.push_back(added) == Status::ok);
  append_block(J_motion, noise);
  return added.slot;
}

void FilterState::append_block(const Mat<6, 12>& J_motion, const Mat6& noise) {
  constexpr int block = 6;
  const int offset = size_;
  // P_new,old = J P_motion,old; P_new,new = J P_motion J' + noise.
  for (int c = 0; c < offset; ++c) {
    for (int r = 0; r < block; ++r) {
      double sum = 0.0;
      for (int k = 0; k < motion_size; ++k) sum += J_motion(r, k) * P_element(k, c);
      P_element(offset + r, c) = sum;
      P_element(c, offset + r) = sum;
    }
  }
  for (int c = 0; c < block; ++c) {
    for (int r = c; r < block; ++r) {
      double sum = noise(r, c);
      for (int k = 0; k < motion_size; ++k) sum += J_motion(r, k) * P_element(offset + c, k);
      P_element(offset + r, offset + c) = sum;
      P_element(offset + c, offset + r) = sum;
    }
  }
  size_ += block;
}

void FilterState::erase_states(int first, int count) {
  const int kept = size_ - count;
  for (int c = 0; c < size_; ++c) {
    for (int r = first; r < kept; ++r) P_element(r, c) = P_element(r + count, c);
  }
  for (int c = first; c < kept; ++c) {
    for (int r = 0; r < kept; ++r) P_element(r, c) = P_element(r, c + count);
  }
  size_ = kept;
}

void FilterState::remove(std::size_t index) {
  const Feature removed = features_[index];
  erase_states(removed.offset, removed.size);
  RELNAV_ASSERT(slots_.release(removed.slot) == Status::ok);
  for (std::size_t i = index; i + 1 < features_.size(); ++i) {
    features_[i] = features_[i + 1];
    features_[i].offset -= removed.size;
  }
  features_.pop_back();
}

void FilterState::make_euclidean(std::size_t index) {
  Feature& f = features_[index];
  Mat<3, 6> J;
  Mat<3, 6> J_unused;
  const Vec3 X_T = inverse_depth::point_T(f.y, J_unused);
  const Vec3 X_lin_T = inverse_depth::point_T(f.y_lin, J);
  const int first = f.offset;
  for (int c = 0; c < size_; ++c) {
    Vec6 old;
    for (int k = 0; k < 6; ++k) old(k) = P_element(first + k, c);
    const Vec3 fresh = J * old;
    for (int k = 0; k < 3; ++k) P_element(first + k, c) = fresh(k);
  }
  for (int r = 0; r < size_; ++r) {
    if (r >= first + 3 && r < first + 6) continue;  // rows about to go
    Vec6 old;
    for (int k = 0; k < 6; ++k) old(k) = P_element(r, first + k);
    const Vec3 fresh = J * old;
    for (int k = 0; k < 3; ++k) P_element(r, first + k) = fresh(k);
  }
  erase_states(first + 3, 3);
  for (int c = 0; c < 3; ++c) {
    for (int r = c + 1; r < 3; ++r) P_element(first + c, first + r) = P_element(first + r, first + c);
  }
  // Rounding differs between the two passes for the cross terms: one triangle is the truth.
  for (int r = 0; r < size_; ++r) {
    for (int k = 0; k < 3; ++k) P_element(first + k, r) = P_element(r, first + k);
  }
  f.y.head<3>() = X_T;
  f.y.tail<3>().setZero();
  f.y_lin.head<3>() = X_lin_T;
  f.y_lin.tail<3>().setZero();
  f.size = 3;
  for (std::size_t i = index + 1; i < features_.size(); ++i) features_[i].offset -= 3;
}

void FilterState::correct(const double* dx) {
  motion.position += Vec3(dx[0], dx[1], dx[2]);
  motion.attitude.rotate(Vec3(motion_lin.attitude.error_jacobian() * Vec3(dx[3], dx[4], dx[5])));
  motion.velocity += Vec3(dx[6], dx[7], dx[8]);
  motion.rate += Vec3(dx[9], dx[10], dx[11]);
  for (Feature& f : features_) {
    for (int k = 0; k < f.size; ++k) f.y(k) += dx[f.offset + k];
  }
}

void FilterState::negate_scale() {
  std::array<double, config::max_states> sign{};
  sign.fill(1.0);
  const auto negate = [&sign](int first, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) sign[static_cast<std::size_t>(first) + k] = -1.0;
  };
  negate(0, 3);
  negate(6, 3);
  motion.position = -motion.position;
  motion.velocity = -motion.velocity;
  motion_lin.position = -motion_lin.position;
  motion_lin.velocity = -motion_lin.velocity;
  for (Feature& f : features_) {
    negate(f.offset, 3);
    f.y.head<3>() = -f.y.head<3>();
    f.y_lin.head<3>() = -f.y_lin.head<3>();
    f.r_TC0 = -f.r_TC0;
    if (f.size == 6) {
      sign[static_cast<std::size_t>(f.offset) + 5] = -1.0;
      f.y(5) = -f.y(5);
      f.y_lin(5) = -f.y_lin(5);
    }
  }
  for (int c = 0; c < size_; ++c) {
    for (int r = 0; r < size_; ++r) {
      P_element(r, c) *= sign[static_cast<std::size_t>(r)] * sign[static_cast<std::size_t>(c)];
    }
  }
}

void FilterState::relinearise() {
  // The covariance is that of the chart at the linearisation point: carried over through dphi, which both share.
  const Mat3 J = motion.attitude.error_jacobian_inverse() * motion_lin.attitude.error_jacobian();
  transform_block(P(), 3, J);
  motion_lin = motion;
  for (Feature& f : features_) f.y_lin = f.y;
}

}  // namespace relnav
