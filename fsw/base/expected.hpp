#pragma once
#include "fsw/base/panic.hpp"
#include "fsw/base/status.hpp"

namespace relnav {

/// A value, or the status that says why there is none. No default state; T is held by value, without heap.
template <typename T>
class [[nodiscard]] Expected {
 public:
  constexpr Expected(const T& value) : value_(value), status_(Status::ok) {}  // NOLINT(google-explicit-constructor)
  constexpr Expected(Status error) : value_(), status_(error) {               // NOLINT(google-explicit-constructor)
    RELNAV_ASSERT(error != Status::ok);
  }

  [[nodiscard]] constexpr bool has_value() const { return status_ == Status::ok; }
  [[nodiscard]] constexpr explicit operator bool() const { return has_value(); }
  [[nodiscard]] constexpr Status status() const { return status_; }
  [[nodiscard]] constexpr const T& value() const {
    RELNAV_ASSERT(has_value());
    return value_;
  }
  [[nodiscard]] constexpr T value_or(const T& fallback) const { return has_value() ? value_ : fallback; }

 private:
  T value_;
  Status status_;
};

}  // namespace relnav
