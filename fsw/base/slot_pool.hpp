#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/base/expected.hpp"
#include "fsw/base/status.hpp"

namespace relnav {

/// Names one use of one slot. The generation tells a handle of a released slot from that of its successor.
struct SlotHandle {
  static constexpr std::uint16_t no_index = 0xFFFF;
  std::uint16_t index = no_index;
  std::uint16_t generation = 0;
  friend constexpr bool operator==(SlotHandle, SlotHandle) = default;
};

/// Hands out the lowest free of `Capacity` fixed slots. Elements never move. O(Capacity) acquire, O(1) all else.
template <std::size_t Capacity>
class SlotPool {
  static_assert(Capacity < SlotHandle::no_index);

 public:
  [[nodiscard]] static constexpr std::size_t capacity() { return Capacity; }
  [[nodiscard]] constexpr std::size_t in_use() const { return in_use_; }
  [[nodiscard]] constexpr bool full() const { return in_use_ == Capacity; }

  /// Status::no_capacity when every slot is taken.
  Expected<SlotHandle> acquire() {
    for (std::size_t i = 0; i < Capacity; ++i) {
      if (!used_[i]) {
        used_[i] = true;
        ++in_use_;
        return SlotHandle{static_cast<std::uint16_t>(i), generation_[i]};
      }
    }
    return Status::no_capacity;
  }

  /// Status::stale_handle when the handle does not name a current use.
  Status release(SlotHandle handle) {
    if (!is_current(handle)) return Status::stale_handle;
    used_[handle.index] = false;
    ++generation_[handle.index];
    --in_use_;
    return Status::ok;
  }

  [[nodiscard]] constexpr bool is_current(SlotHandle handle) const {
    return handle.index < Capacity && used_[handle.index] && generation_[handle.index] == handle.generation;
  }
  [[nodiscard]] constexpr bool is_used(std::size_t index) const { return index < Capacity && used_[index]; }
  /// Handle of the current use of a used slot.
  [[nodiscard]] constexpr SlotHandle handle_of(std::size_t index) const {
    RELNAV_ASSERT(is_used(index));
    return SlotHandle{static_cast<std::uint16_t>(index), generation_[index]};
  }

 private:
  std::array<bool, Capacity> used_{};
  std::array<std::uint16_t, Capacity> generation_{};
  std::size_t in_use_ = 0;
};

}  // namespace relnav
