#include "fsw/estimation/filter_state.hpp"

#include "fsw/estimation/inverse_depth.hpp"

namespace relnav {

void FilterState::set_motion(const MotionState& start, const Mat12& P_motion) {
  motion = start;
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
  append_block(J_motion, {}, noise);
}

Feature* FilterState::find(SlotHandle slot) {
  for (Feature& f : features_) {
    if (f.slot == slot) return &f;
  }
  return nullptr;
}

Expected<SlotHandle> FilterState::add(const Feature& feature, const Mat<6, 12>& J_motion, const DepthTerms& depth_terms,
                                      const Mat6& noise) {
  const Expected<SlotHandle> slot = slots_.acquire();
  if (!slot) return slot.status();
  Feature added = feature;
  added.slot = slot.value();
  added.offset = size_;
  added.size = 6;
  RELNAV_ASSERT(features_.push_back(added) == Status::ok);
  append_block(J_motion, depth_terms, noise);
  return added.slot;
}

void FilterState::append_block(const Mat<6, 12>& J_motion, const DepthTerms& depth_terms, const Mat6& noise) {
  constexpr int block = 6;
  constexpr int rho = 5;
  const int offset = size_;
  // P_new,old = J P_old,old; P_new,new = J P_old,new + noise. J: motion for all rows, other features for rho's.
  const auto row_times = [&](int r, const double* P_column) {
    double sum = 0.0;
    for (int k = 0; k < motion_size; ++k) sum += J_motion(r, k) * P_column[k];
    if (r != rho) return sum;
    for (const DepthTerm& term : depth_terms) {
      for (int k = 0; k < term.size; ++k) sum += term.J(k) * P_column[term.offset + k];
    }
    return sum;
  };
  for (int c = 0; c < offset; ++c) {
    for (int r = 0; r < block; ++r) P_element(offset + r, c) = row_times(r, &P_element(0, c));
  }
  for (int c = 0; c < block; ++c) {
    for (int r = 0; r < offset; ++r) P_element(r, offset + c) = P_element(offset + c, r);
  }
  for (int c = 0; c < block; ++c) {
    for (int r = c; r < block; ++r) {
      const double covariance = row_times(r, &P_element(0, offset + c)) + noise(r, c);
      P_element(offset + r, offset + c) = covariance;
      P_element(offset + c, offset + r) = covariance;
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
  const Vec3 X_T = inverse_depth::point_T(f.y, J);
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
  f.size = 3;
  for (std::size_t i = index + 1; i < features_.size(); ++i) features_[i].offset -= 3;
}

void FilterState::correct(const double* dx) {
  motion.position += Vec3(dx[0], dx[1], dx[2]);
  motion.attitude.add(Vec3(dx[3], dx[4], dx[5]));
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
  for (Feature& f : features_) {
    negate(f.offset, 3);
    f.y.head<3>() = -f.y.head<3>();
    f.r_TC0 = -f.r_TC0;
    if (f.size == 6) {
      sign[static_cast<std::size_t>(f.offset) + 5] = -1.0;
      f.y(5) = -f.y(5);
    }
  }
  for (int c = 0; c < size_; ++c) {
    for (int r = 0; r < size_; ++r) {
      P_element(r, c) *= sign[static_cast<std::size_t>(r)] * sign[static_cast<std::size_t>(c)];
    }
  }
}

void FilterState::loosen(std::size_t index, double sigma_m) {
  const Feature& f = features_[index];
  // Azimuth and elevation move by the angle that the anchor sees; near the poles of elevation the azimuth would move more,
  // which loosens less than asked for.
  const double sigma = f.size == 3 ? sigma_m : sigma_m * f.y(5);
  const int first = f.size == 3 ? f.offset : f.offset + 3;
  const int count = f.size == 3 ? 3 : 2;
  for (int k = first; k < first + count; ++k) P_element(k, k) += sigma * sigma;
}

}  // namespace relnav
