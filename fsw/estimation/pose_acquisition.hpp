#pragma once
#include <array>

#include "fsw/estimation/pose_least_squares.hpp"

namespace relnav {

/// A pose found without any prior. When another one explains the observations as well, both are given.
struct AcquiredPose {
  PoseEstimate best;
  bool ambiguous = false;
  PoseEstimate other;  ///< valid if ambiguous
};

struct AcquisitionSettings {
  PoseSolverSettings solver;
  double ambiguous_chi2 = 20.0;    ///< a second minimum whose chi-square is larger by less than this is not excluded
  double alarm_chi2_factor = 3.0;  ///< chi-square over degrees of freedom from which on more starts are tried
};

/// Pose from identified observations, any attitude, no prior. Two starts from the scaled orthographic image of the
/// feature's principal plane (the two signs of what it leaves open: DeMenthon, Davis, IJCV 15, 1995; Oberkampf, DeMenthon,
/// Davis, CVIU 63(3), 1996), in a camera turned to the features; both are refined by solve_pose() and the better is kept.
/// If neither fits, 24 attitudes spread over SO(3). Bounded: at most 26 solutions.
/// Planar and distant targets have two minima: see AcquiredPose::ambiguous.
/// ok; too_few_features: fewer than 4 in the camera that sees most of them; rank_deficient: they lie on a line;
/// no_convergence: no start led anywhere; else as solve_pose().
Status acquire_pose(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                    const ObservationMask& used, const AcquisitionSettings& settings, AcquiredPose& out);

/// The two starts by themselves, from the observations of one camera. Errors as acquire_pose().
Status orthographic_starts(const CameraRig& rig, const TargetModel& target, const PoseObservations& observations,
                           const ObservationMask& used, std::uint16_t camera, std::array<Pose, 2>& starts);

}  // namespace relnav
