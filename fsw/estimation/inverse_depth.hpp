#pragma once
#include "fsw/math/types.hpp"

namespace relnav {

/// Inverse-depth point y = (x y z theta phi rho): anchor position in T (m), azimuth and elevation of the ray in T (rad),
/// inverse distance from the anchor (1/m). Liu 2017 eq. (1)-(6), after Civera 2008.
/// Point in T: (x y z) + m(theta, phi) / rho, valid for rho > 0; a ray through infinity at rho = 0.
namespace inverse_depth {

/// m = (cos phi sin theta, -sin phi, cos phi cos theta), eq. (4). Unit length.
[[nodiscard]] Vec3 ray_T(double theta, double phi);
/// Same with dm/dtheta and dm/dphi.
[[nodiscard]] Vec3 ray_T(double theta, double phi, Vec3& dm_dtheta, Vec3& dm_dphi);
/// Azimuth and elevation of a direction, eq. (2), (3): theta = atan2(x, z), phi = atan2(-y, sqrt(x^2 + z^2)).
/// J = d(theta, phi)/d(direction); singular only for directions along T's y axis (then a zero Jacobian is returned).
void angles_of(const Vec3& direction_T, double& theta, double& phi, Mat23& J);
/// Euclidean point and its Jacobian (3 x 6), eq. (6). rho != 0.
[[nodiscard]] Vec3 point_T(const Vec6& y, Mat<3, 6>& J);

/// Linearity index of the Euclidean form, eq. (7)-(9): L_d = 4 sigma_d / d_1 |cos alpha|, sigma_d = sigma_rho / rho^2,
/// d_1 the distance from the camera now, alpha the parallax angle. Small is linear. Infinite when rho <= 0.
[[nodiscard]] double euclidean_linearity_index(const Vec6& y, double sigma_rho, const Vec3& r_TC);

}  // namespace inverse_depth
}  // namespace relnav
