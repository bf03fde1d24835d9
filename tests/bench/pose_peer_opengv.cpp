// OpenGV's solvers for bench_pose. Its pose is that of the camera in T.
#include <opengv/absolute_pose/CentralAbsoluteAdapter.hpp>
#include <opengv/absolute_pose/methods.hpp>

#include <limits>
#include <vector>

#include "tests/bench/pose_peer.hpp"

namespace {

using relnav::bench::Peer;
using relnav::bench::PeerView;

struct View {
  opengv::bearingVectors_t rays;
  opengv::points_t points;
  opengv::rotation_t R_TC;
  opengv::translation_t c_T;
};

std::vector<View>& views() {
  static std::vector<View> all;
  return all;
}

void give(const opengv::transformation_t& pose, double* R_CT, double* t_CT) {
  const opengv::rotation_t R = pose.leftCols<3>().transpose();
  const Eigen::Vector3d t = -(R * pose.col(3));
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) R_CT[3 * r + c] = R(r, c);
    t_CT[r] = t(r);
  }
}

bool solve_epnp(int i, double* R_CT, double* t_CT) {
  const View& v = views()[static_cast<std::size_t>(i)];
  const opengv::absolute_pose::CentralAbsoluteAdapter adapter(v.rays, v.points);
  give(opengv::absolute_pose::epnp(adapter), R_CT, t_CT);
  return true;
}

/// The best of what it offers, by the angle between rays.
bool solve_upnp(int i, double* R_CT, double* t_CT) {
  const View& v = views()[static_cast<std::size_t>(i)];
  const opengv::absolute_pose::CentralAbsoluteAdapter adapter(v.rays, v.points);
  const opengv::transformations_t poses = opengv::absolute_pose::upnp(adapter);
  double least = std::numeric_limits<double>::infinity();
  for (const opengv::transformation_t& pose : poses) {
    double sum = 0.0;
    for (std::size_t k = 0; k < v.rays.size(); ++k) {
      sum += 1.0 - v.rays[k].dot((pose.leftCols<3>().transpose() * (v.points[k] - pose.col(3))).normalized());
    }
    if (sum < least) {
      least = sum;
      give(pose, R_CT, t_CT);
    }
  }
  return !poses.empty();
}

bool refine(int i, double* R_CT, double* t_CT) {
  const View& v = views()[static_cast<std::size_t>(i)];
  const opengv::absolute_pose::CentralAbsoluteAdapter adapter(v.rays, v.points, v.c_T, v.R_TC);
  give(opengv::absolute_pose::optimize_nonlinear(adapter), R_CT, t_CT);
  return true;
}

constexpr Peer solvers[] = {
    {"warm_opengv_nonlinear", refine}, {"cold_opengv_upnp", solve_upnp}, {"cold_opengv_epnp", solve_epnp}};

}  // namespace

int relnav_peers_opengv(const PeerView* given, int count, const Peer** peers) {
  for (int i = 0; i < count; ++i) {
    View v;
    for (int k = 0; k < relnav::bench::peer_points; ++k) {
      v.points.emplace_back(given[i].p_T[k][0], given[i].p_T[k][1], given[i].p_T[k][2]);
      v.rays.push_back(Eigen::Vector3d(given[i].xy[k][0], given[i].xy[k][1], 1.0).normalized());
    }
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R_CT(given[i].R_CT);
    const Eigen::Map<const Eigen::Vector3d> t_CT(given[i].t_CT);
    v.R_TC = R_CT.transpose();
    v.c_T = -(v.R_TC * t_CT);
    views().push_back(v);
  }
  *peers = solvers;
  return 3;
}
