// What most tests include, for the compiler to read once (tests/CMakeLists.txt). Tests include what they use all the same.
// Without CppUTest, whose macros replace `new` in standard headers that come after it.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Dense>
