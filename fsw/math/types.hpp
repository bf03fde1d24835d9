#pragma once
#include <Eigen/Core>

namespace relnav {

// Small fixed matrices, passed by reference. Anything of order n^2 goes through math/covariance_kernels.hpp.
template <int Rows, int Cols = 1>
using Mat = Eigen::Matrix<double, Rows, Cols>;
using Vec2 = Mat<2>;
using Vec3 = Mat<3>;
using Vec6 = Mat<6>;
using Mat2 = Mat<2, 2>;
using Mat3 = Mat<3, 3>;
using Mat6 = Mat<6, 6>;
using Mat23 = Mat<2, 3>;

constexpr double pi = 3.14159265358979323846;

}  // namespace relnav
