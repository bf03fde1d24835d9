#pragma once
#include <array>
#include <cstddef>

#include "fsw/base/panic.hpp"
#include "fsw/base/status.hpp"

namespace relnav {

/// Array of at most Capacity elements with a current size. No heap; elements are contiguous.
/// T needs a default constructor and assignment (all elements live for the container's lifetime).
template <typename T, std::size_t Capacity>
class BoundedVector {
 public:
  using value_type = T;

  [[nodiscard]] static constexpr std::size_t capacity() { return Capacity; }
  [[nodiscard]] constexpr std::size_t size() const { return size_; }
  [[nodiscard]] constexpr bool empty() const { return size_ == 0; }
  [[nodiscard]] constexpr bool full() const { return size_ == Capacity; }

  /// Status::no_capacity when full; the container is then unchanged.
  Status push_back(const T& value) {
    if (full()) return Status::no_capacity;
    items_[size_++] = value;
    return Status::ok;
  }
  constexpr void pop_back() {
    RELNAV_ASSERT(size_ > 0);
    --size_;
  }
  constexpr void clear() { size_ = 0; }
  /// Keeps the first `size` elements (size <= current size).
  constexpr void truncate(std::size_t size) {
    RELNAV_ASSERT(size <= size_);
    size_ = size;
  }

  [[nodiscard]] constexpr T& operator[](std::size_t i) {
    RELNAV_ASSERT(i < size_);
    return items_[i];
  }
  [[nodiscard]] constexpr const T& operator[](std::size_t i) const {
    RELNAV_ASSERT(i < size_);
    return items_[i];
  }
  [[nodiscard]] constexpr T* data() { return items_.data(); }
  [[nodiscard]] constexpr const T* data() const { return items_.data(); }
  [[nodiscard]] constexpr T* begin() { return items_.data(); }
  [[nodiscard]] constexpr T* end() { return items_.data() + size_; }
  [[nodiscard]] constexpr const T* begin() const { return items_.data(); }
  [[nodiscard]] constexpr const T* end() const { return items_.data() + size_; }

 private:
  std::array<T, Capacity> items_{};
  std::size_t size_ = 0;
};

}  // namespace relnav
