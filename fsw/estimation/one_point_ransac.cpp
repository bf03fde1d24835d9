#include "fsw/estimation/one_point_ransac.hpp"

#include "fsw/math/elementary.hpp"

namespace relnav {
namespace {

/// Hypotheses needed at inlier ratio p, eq. (24).
int hypotheses_needed(double confidence, double inlier_ratio, int most) {
  if (inlier_ratio >= 1.0) return 1;
  if (inlier_ratio <= 0.0) return most;
  const double needed = math::log(1.0 - confidence) / math::log(1.0 - inlier_ratio);
  if (!(needed < static_cast<double>(most))) return most;
  return static_cast<int>(needed) + 1;
}

}  // namespace

RansacResult one_point_ransac(const RansacConfig& settings, Generator& generator, const CameraModel& camera,
                              const MotionModel& model, const FilterState& state, const CompatibleMatches& matches,
                              const Innovations& innovations, const EkfUpdate& update) {
  RansacResult best;
  const auto count = static_cast<std::uint32_t>(matches.size());
  if (count == 0) return best;

  // Draw without replacement: a match tried once teaches nothing the second time.
  std::array<std::uint16_t, config::max_features> order{};
  for (std::uint32_t i = 0; i < count; ++i) order[i] = static_cast<std::uint16_t>(i);

  std::array<double, config::max_states> dx{};
  int needed = settings.max_hypotheses < static_cast<int>(count) ? settings.max_hypotheses : static_cast<int>(count);
  for (int h = 0; h < needed; ++h) {
    const auto first = static_cast<std::uint32_t>(h);
    const std::uint32_t pick = first + generator.below(count - first);
    const std::uint16_t chosen = order[pick];
    order[pick] = order[first];
    order[first] = chosen;
    ++best.hypotheses;

    if (update.state_step(state, innovations, chosen, dx.data()) != Status::ok) continue;
    MotionState motion = state.motion;
    motion.position += Vec3(dx[0], dx[1], dx[2]);
    motion.attitude.add(Vec3(dx[3], dx[4], dx[5]));
    const PoseLinearisation pose = model.pose(motion);

    std::array<bool, config::max_features> inlier{};
    int inliers = 0;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      Feature feature = state.features()[matches[i].feature];
      for (int k = 0; k < feature.size; ++k) feature.y(k) += dx[static_cast<std::size_t>(feature.offset + k)];
      Vec2 uv_px;
      if (predict_pixel(camera, pose, feature, uv_px) != Status::ok) continue;
      const double limit = settings.threshold_sigma * matches[i].sigma_px;
      if ((matches[i].uv_px - uv_px).squaredNorm() < limit * limit) {
        inlier[i] = true;
        ++inliers;
      }
    }
    if (inliers > best.inliers) {
      best.inliers = inliers;
      best.inlier = inlier;
      const int most = needed;
      needed = hypotheses_needed(settings.confidence, static_cast<double>(inliers) / count, settings.max_hypotheses);
      if (needed > most) needed = most;
    }
  }
  return best;
}

}  // namespace relnav
