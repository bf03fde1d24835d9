#pragma once
#include <cstdint>

#include "fsw/attitude/mrp.hpp"
#include "fsw/attitude/rodrigues.hpp"
#include "fsw/math/types.hpp"

namespace relnav {

enum class AttitudeChartKind : std::uint8_t { mrp, rodrigues };

/// The attitude part of the filter's state: R_CT in the chart chosen at configuration.
class AttitudeState {
 public:
  AttitudeState() = default;
  AttitudeState(AttitudeChartKind kind, const Mat3& R_CT)
      : kind_(kind), mrp_(MrpChart::from_dcm(R_CT)), rodrigues_(RodriguesChart::from_dcm(R_CT)) {}

  [[nodiscard]] AttitudeChartKind kind() const { return kind_; }
  [[nodiscard]] Mat3 dcm() const { return is_mrp() ? mrp_.dcm() : rodrigues_.dcm(); }
  [[nodiscard]] Vec3 parameters() const { return is_mrp() ? mrp_.parameters() : rodrigues_.parameters(); }
  [[nodiscard]] int set_index() const { return is_mrp() ? mrp_.set_index() : rodrigues_.set_index(); }

  /// Additive correction of the parameters, as an EKF update makes it.
  void add(const Vec3& delta) {
    if (is_mrp()) {
      mrp_.add(delta);
    } else {
      rodrigues_.add(delta);
    }
  }
  /// A with R(p + dp) = Exp([A dp x]) R(p): chart errors to dphi in C.
  [[nodiscard]] Mat3 error_jacobian() const { return is_mrp() ? mrp_.error_jacobian() : rodrigues_.error_jacobian(); }
  [[nodiscard]] Mat3 error_jacobian_inverse() const {
    return is_mrp() ? mrp_.error_jacobian_inverse() : rodrigues_.error_jacobian_inverse();
  }
  /// Replaces R_CT by Exp([phi_C x]) R_CT; gives d p'/d p and d p'/d phi_C.
  void rotate(const Vec3& phi_C, Mat3& dp_dp, Mat3& dp_dphi) {
    if (is_mrp()) {
      mrp_ = mrp_.rotated(phi_C, dp_dp, dp_dphi);
    } else {
      rodrigues_ = rodrigues_.rotated(phi_C, dp_dp, dp_dphi);
    }
  }
  /// Same without Jacobians.
  void rotate(const Vec3& phi_C) {
    if (is_mrp()) {
      mrp_ = mrp_.rotated(phi_C);
    } else {
      rodrigues_ = rodrigues_.rotated(phi_C);
    }
  }
  /// Applies the chart's switching rule. True when it switched; J = d p_new / d p_old.
  [[nodiscard]] bool switch_if_due(Mat3& J) { return is_mrp() ? mrp_.switch_if_due(J) : rodrigues_.switch_if_due(J); }

 private:
  [[nodiscard]] bool is_mrp() const { return kind_ == AttitudeChartKind::mrp; }

  AttitudeChartKind kind_ = AttitudeChartKind::mrp;
  MrpChart mrp_ = MrpChart::from_dcm(Mat3::Identity());
  RodriguesChart rodrigues_ = RodriguesChart::from_dcm(Mat3::Identity());
};

}  // namespace relnav
