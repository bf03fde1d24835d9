#pragma once
#include <cstddef>
#include <vector>

namespace relnav::platform::host {

/// First-in first-out list with all its memory taken at construction, so that a stub does not allocate while the loop runs.
template <typename T>
class BoundedRecord {
 public:
  explicit BoundedRecord(std::size_t capacity) { items_.reserve(capacity); }

  /// False when full; the item is then only counted as dropped.
  bool push(const T& item) {
    if (items_.size() == items_.capacity()) {
      ++dropped_;
      return false;
    }
    items_.push_back(item);
    return true;
  }
  /// Items never taken by next() stay readable by index.
  [[nodiscard]] bool has_next() const { return read_ < items_.size(); }
  [[nodiscard]] T& next() { return items_[read_]; }
  void skip() { ++read_; }

  [[nodiscard]] std::size_t size() const { return items_.size(); }
  [[nodiscard]] std::size_t pending() const { return items_.size() - read_; }
  [[nodiscard]] std::size_t dropped() const { return dropped_; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return items_[i]; }
  [[nodiscard]] auto begin() const { return items_.begin(); }
  [[nodiscard]] auto end() const { return items_.end(); }
  void clear() {
    items_.clear();
    read_ = 0;
    dropped_ = 0;
  }

 private:
  std::vector<T> items_;
  std::size_t read_ = 0;
  std::size_t dropped_ = 0;
};

}  // namespace relnav::platform::host
