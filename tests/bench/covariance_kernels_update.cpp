// The flight kernels behind the border of covariance_case.hpp. Compiled together with covariance_kernels.cpp, once per
// instruction set; RELNAV_ENTRY is the exported name.
#include <cstdlib>
#include <cstring>
#include <vector>

#include "fsw/math/covariance_kernels.hpp"
#include "tests/bench/covariance_case.hpp"

namespace relnav {
void panic(const char*, int, const char*) { std::abort(); }
}  // namespace relnav

namespace {

using namespace relnav;
namespace b = relnav::bench;

MatrixStorage<b::states, b::states> covariance;
MatrixStorage<b::states, b::rows> gain;
MatrixStorage<b::rows, b::rows> innovation;
SparseRowPair pairs[b::pairs];
const b::Case* source = nullptr;

MatrixView P() { return covariance.view(b::states, b::states); }
MatrixView B() { return gain.view(b::states, b::rows); }
MatrixView S() { return innovation.view(b::rows, b::rows); }

void prepare(const b::Case* c) {
  source = c;
  for (int i = 0; i < b::pairs; ++i) {
    pairs[i].feature_offset = c->feature_offset[i];
    pairs[i].feature_size = b::feature;
    for (int k = 0; k < 2; ++k) {
      std::memcpy(pairs[i].motion[k], c->motion_coefficients + (2 * i + k) * b::motion, sizeof(pairs[i].motion[k]));
      std::memcpy(pairs[i].feature[k], c->feature_coefficients + (2 * i + k) * b::feature, sizeof(pairs[i].feature[k]));
    }
  }
}
void restore() {
  for (int c = 0; c < b::states; ++c) std::memcpy(P().col(c), source->P + c * b::states, sizeof(double) * b::states);
}
bool part(int which) {
  switch (which) {
    case b::p_ht: multiply_p_ht(P(), pairs, B()); return true;
    case b::s: innovation_covariance(pairs, B(), source->r, S()); return true;
    case b::cholesky: return cholesky_lower(S()) == Status::ok;
    case b::solve: solve_right_transposed(S(), B()); return true;
    default: downdate_symmetric(P(), B()); return true;
  }
}
bool update() {
  for (int i = 0; i < b::part_count; ++i) {
    if (!part(i)) return false;
  }
  return true;
}
void result(double* out) {
  for (int c = 0; c < b::states; ++c) std::memcpy(out + c * b::states, P().col(c), sizeof(double) * b::states);
}

}  // namespace

extern "C" const b::Update* RELNAV_ENTRY() {
  static const b::Update entry = {prepare, restore, update, part, result};
  return &entry;
}
