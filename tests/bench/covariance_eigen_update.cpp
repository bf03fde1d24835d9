// The same update by Eigen without our restrictions: heap, vector intrinsics, FMA where the instruction set has it.
// Fixed leading dimension 264 would not help Eigen's own packing; plain MatrixXd is what a user would write.
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "tests/bench/covariance_case.hpp"

namespace {

namespace b = relnav::bench;
using Eigen::MatrixXd;

struct Workspace {
  MatrixXd P{b::states, b::states};
  MatrixXd motion{b::rows, b::motion};
  MatrixXd feature{b::rows, b::feature};
  MatrixXd PHt{b::states, b::rows};
  MatrixXd S{b::rows, b::rows};
  MatrixXd W{b::rows, b::states};
  Eigen::LLT<MatrixXd> llt{b::rows};
  const b::Case* source = nullptr;
};
Workspace* w = nullptr;

void prepare(const b::Case* c) {
  if (w == nullptr) w = new Workspace;
  w->source = c;
  for (int i = 0; i < b::rows; ++i) {
    for (int k = 0; k < b::motion; ++k) w->motion(i, k) = c->motion_coefficients[i * b::motion + k];
    for (int k = 0; k < b::feature; ++k) w->feature(i, k) = c->feature_coefficients[i * b::feature + k];
  }
}
void restore() { w->P = Eigen::Map<const MatrixXd>(w->source->P, b::states, b::states); }
bool part(int which) {
  switch (which) {
    case b::p_ht:
      // Only the six columns that the rows use: the same saving as ours.
      w->PHt.noalias() = w->P.leftCols<6>() * w->motion.leftCols<6>().transpose();
      for (int i = 0; i < b::pairs; ++i) {
        w->PHt.middleCols<2>(2 * i).noalias() += w->P.middleCols<b::feature>(w->source->feature_offset[i])
                                                     .lazyProduct(w->feature.middleRows<2>(2 * i).transpose());
      }
      return true;
    case b::s:
      w->S.noalias() = w->motion.leftCols<6>() * w->PHt.topRows<6>();
      for (int i = 0; i < b::pairs; ++i) {
        w->S.middleRows<2>(2 * i).noalias() +=
            w->feature.middleRows<2>(2 * i).lazyProduct(w->PHt.middleRows<b::feature>(w->source->feature_offset[i]));
      }
      w->S.diagonal() += Eigen::Map<const Eigen::VectorXd>(w->source->r, b::rows);
      return true;
    case b::cholesky: w->llt.compute(w->S); return w->llt.info() == Eigen::Success;
    case b::solve:
      w->W = w->PHt.transpose();
      w->llt.matrixL().solveInPlace(w->W);
      return true;
    default:
      w->P.selfadjointView<Eigen::Lower>().rankUpdate(w->W.transpose(), -1.0);
      w->P.triangularView<Eigen::StrictlyUpper>() = w->P.transpose();
      return true;
  }
}
bool update() {
  for (int i = 0; i < b::part_count; ++i) {
    if (!part(i)) return false;
  }
  return true;
}
void result(double* out) { Eigen::Map<MatrixXd>(out, b::states, b::states) = w->P; }

}  // namespace

extern "C" const b::Update* RELNAV_ENTRY() {
  static const b::Update entry = {prepare, restore, update, part, result};
  return &entry;
}
