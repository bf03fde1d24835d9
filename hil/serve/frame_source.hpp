#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hil/io/image_entry.hpp"
#include "hil/serve/frame_sink.hpp"

namespace relnav::hil {

/// Captured frames in their order.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  [[nodiscard]] virtual std::size_t count() const = 0;
  [[nodiscard]] virtual FrameShape shape() const = 0;
  [[nodiscard]] virtual Time stamp(std::size_t index) const = 0;
  /// Throws InputError.
  virtual std::shared_ptr<const Image> image(std::size_t index) = 0;
};

/// One camera of a data set.
class CapturedSource final : public FrameSource {
 public:
  /// `images`: CameraFiles::images. Throws InputError.
  explicit CapturedSource(const std::string& images);
  /// What is not as it should be, one line each.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  [[nodiscard]] std::size_t count() const override { return entries_.size(); }
  [[nodiscard]] FrameShape shape() const override { return shape_; }
  [[nodiscard]] Time stamp(std::size_t index) const override { return entries_[index].time; }
  std::shared_ptr<const Image> image(std::size_t index) override;

 private:
  std::vector<std::string> notes_;
  std::vector<ImageEntry> entries_;
  FrameShape shape_;
  std::vector<std::shared_ptr<const Image>> kept_;  ///< decoded once, as long as memory lasts
  std::size_t kept_bytes_ = 0;
};

}  // namespace relnav::hil
