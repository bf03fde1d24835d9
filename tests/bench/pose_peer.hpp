#pragma once

// Solvers of other libraries on the same views, as plain data: it crosses the border of shared libraries that are compiled with
// Eigen's own settings, and so must not carry an Eigen or a std type.

namespace relnav::bench {

inline constexpr int peer_points = 8;

/// Normalised image coordinates; poses p_C = R_CT p_T + t_CT, row by row.
struct PeerView {
  double p_T[peer_points][3];
  double xy[peer_points][2];
  double R_CT[9];  // of the guess
  double t_CT[3];
};

struct Peer {
  const char* name;
  bool (*solve)(int view, double* R_CT, double* t_CT);
};

}  // namespace relnav::bench

extern "C" {
/// What each library exports: takes the views, gives its solvers, returns how many.
[[gnu::visibility("default")]] int relnav_peers_opengv(const relnav::bench::PeerView* views, int count,
                                                       const relnav::bench::Peer** peers);
[[gnu::visibility("default")]] int relnav_peers_visp(const relnav::bench::PeerView* views, int count,
                                                     const relnav::bench::Peer** peers);
}
