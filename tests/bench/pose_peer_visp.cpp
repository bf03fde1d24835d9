// ViSP's solvers for bench_pose.
#include <visp3/vision/vpPose.h>

#include <vector>

#include "tests/bench/pose_peer.hpp"

namespace {

using relnav::bench::Peer;
using relnav::bench::PeerView;

struct View {
  vpPose problem;
  vpHomogeneousMatrix guess;
};

std::vector<View>& views() {
  static std::vector<View> all;
  return all;
}

template <vpPose::vpPoseMethodType method>
bool solve(int i, double* R_CT, double* t_CT) {
  View& v = views()[static_cast<std::size_t>(i)];
  vpHomogeneousMatrix pose = v.guess;
  if (!v.problem.computePose(method, pose)) return false;
  for (unsigned r = 0; r < 3; ++r) {
    for (unsigned c = 0; c < 3; ++c) R_CT[3 * r + c] = pose[r][c];
    t_CT[r] = pose[r][3];
  }
  return true;
}

constexpr Peer solvers[] = {{"warm_visp_virtual_vs", solve<vpPose::VIRTUAL_VS>},
                            {"cold_visp_dementhon", solve<vpPose::DEMENTHON>},
                            {"cold_visp_dementhon_virtual_vs", solve<vpPose::DEMENTHON_VIRTUAL_VS>},
                            {"cold_visp_lagrange", solve<vpPose::LAGRANGE>},
                            {"cold_visp_lagrange_virtual_vs", solve<vpPose::LAGRANGE_VIRTUAL_VS>}};

}  // namespace

int relnav_peers_visp(const PeerView* given, int count, const Peer** peers) {
  views().resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    View& v = views()[static_cast<std::size_t>(i)];
    for (int k = 0; k < relnav::bench::peer_points; ++k) {
      vpPoint point(given[i].p_T[k][0], given[i].p_T[k][1], given[i].p_T[k][2]);
      point.set_x(given[i].xy[k][0]);
      point.set_y(given[i].xy[k][1]);
      v.problem.addPoint(point);
    }
    for (unsigned r = 0; r < 3; ++r) {
      for (unsigned c = 0; c < 3; ++c) v.guess[r][c] = given[i].R_CT[3 * r + c];
      v.guess[r][3] = given[i].t_CT[r];
    }
  }
  *peers = solvers;
  return 5;
}
