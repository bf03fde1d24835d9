#pragma once
#include <stdexcept>
#include <string>

namespace relnav {

/// Unusable input (exit status 2). what() is one line: place, what is wrong, what was expected.
class InputError : public std::runtime_error {
 public:
  /// `line` counts from 1; 0 when no line applies.
  InputError(const std::string& file, int line, const std::string& problem, const std::string& expectation)
      : std::runtime_error(file + (line > 0 ? ":" + std::to_string(line) : std::string()) + ": " + problem +
                           " (expected " + expectation + ")") {}
};

}  // namespace relnav
