#pragma once
// The closed forms for two cameras a second time, by other means: QR and SVD on the stacked equations instead of normal
// equations and eigenvectors, quaternions for rotors, Kabsch's rotation for the orthogonal method.
#include <utility>
#include <vector>

#include "fsw/geometry/camera_rig.hpp"
#include "fsw/geometry/pose_observation.hpp"

namespace relnav::test {

/// Chen, Chen, Wang 2015, (1): A p = b from both projections.
Vec3 reference_point(const CameraRig& rig, const PoseObservation& left, const PoseObservation& right);

enum class LineScale { unit, as_printed };  ///< as_printed: n = B - A, m = A x B

/// Rotor: unit null vector of n' q - q n = 0, all lines stacked; translator: t x n' = m' - R m, all lines stacked.
Pose reference_motor(const std::vector<Vec3>& p_T, const std::vector<Vec3>& p_C,
                     const std::vector<std::pair<std::size_t, std::size_t>>& lines, LineScale scale);

/// Rotation that takes a set of directions to another one best: Kabsch, Acta Crystallographica A32, 1976.
Mat3 reference_rotation(const std::vector<Vec3>& from, const std::vector<Vec3>& to);

/// Triples (A, B, C) of neighbours: AB, AC and their normal, unit length; position: the mean of the points.
Pose reference_orthogonal(const std::vector<Vec3>& p_T, const std::vector<Vec3>& p_C);

}  // namespace relnav::test
