#include "fsw/estimation/spot_field.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace relnav {
namespace {

constexpr double least_cosine = 0.17364817766693033;  // of 80 deg

}  // namespace

void SpotField::build(const CameraModel& camera, const LightSpots& spots, double gate_px) {
  present_ = 0;
  count_ = 0;
  grid_.fill(0);
  std::array<double, config::max_spots> gate{};
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();
  for (std::size_t i = 0; i < spots.size(); ++i) {
    Vec3 ray;
    Mat<3, 2> J;
    if (camera.unproject(spots[i].uv_px, ray, J) != Status::ok) continue;
    const Vec3 unit = ray.normalized();
    if (!(unit.z() >= least_cosine)) continue;
    rays_[i] = unit;
    xy_[i] = ray.head<2>() / ray.z();
    // d (x/z, y/z) / d uv; its mean square singular value stands for the scale.
    Mat2 J_xy = J.topRows<2>();
    J_xy -= xy_[i] * J.row(2);
    gate[i] = gate_px * std::sqrt(0.5 * J_xy.squaredNorm()) / ray.z();
    inverse_gate2_[i] = 1.0 / (gate[i] * gate[i]);
    const Vec2 reach(gate[i], gate[i]);
    low = count_ == 0 ? Vec2(xy_[i] - reach) : Vec2(low.cwiseMin(xy_[i] - reach));
    high = count_ == 0 ? Vec2(xy_[i] + reach) : Vec2(high.cwiseMax(xy_[i] + reach));
    present_ |= Mask{1} << i;
    ++count_;
  }
  if (count_ == 0) return;
  corner_ = low;
  scale_ = Vec2(cells / (high.x() - low.x()), cells / (high.y() - low.y()));
  const auto cell_of = [](double value) { return std::clamp(static_cast<int>(value), 0, cells - 1); };
  for (std::size_t i = 0; i < spots.size(); ++i) {
    if ((present_ >> i & 1U) == 0) continue;
    const int x0 = cell_of((xy_[i].x() - gate[i] - corner_.x()) * scale_.x());
    const int x1 = cell_of((xy_[i].x() + gate[i] - corner_.x()) * scale_.x());
    const int y0 = cell_of((xy_[i].y() - gate[i] - corner_.y()) * scale_.y());
    const int y1 = cell_of((xy_[i].y() + gate[i] - corner_.y()) * scale_.y());
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) grid_[static_cast<std::size_t>(y * cells + x)] |= Mask{1} << i;
    }
  }
}

int SpotField::nearest(double x, double y, Mask taken, double& d2) const {
  const double column = (x - corner_.x()) * scale_.x();
  const double row = (y - corner_.y()) * scale_.y();
  if (!(column >= 0.0 && column < cells && row >= 0.0 && row < cells)) return -1;
  Mask near = grid_[static_cast<std::size_t>(static_cast<int>(row) * cells + static_cast<int>(column))] & ~taken;
  int best = -1;
  d2 = 1.0;
  while (near != 0) {  // bound: max_spots, a bit of `near` each
    const int i = std::countr_zero(near);
    near &= near - 1;
    const auto k = static_cast<std::size_t>(i);
    const double dx = x - xy_[k].x();
    const double dy = y - xy_[k].y();
    const double e2 = (dx * dx + dy * dy) * inverse_gate2_[k];
    if (e2 < d2) {
      d2 = e2;
      best = i;
    }
  }
  return best;
}

}  // namespace relnav
