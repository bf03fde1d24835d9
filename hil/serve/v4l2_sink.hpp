#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hil/serve/frame_sink.hpp"
#include "hil/serve/trigger_input.hpp"

namespace relnav::hil {

/// A V4L2 camera: the other end of a v4l2loopback device (one with exclusive_caps=1 is a camera only while this is plugged).
/// GREY for 8 bits, Y16 for 16. Frames bear the capture's stamps, cut to microseconds as V4L2 has them; a stamp of 0 cannot be
/// sent. The driver counts no frames then: every sequence number is 0. Needs lock step (a trigger) for readers that must see
/// each frame whole: the driver has one ring of buffers for both sides, and a fast writer overtakes a reader.
class V4l2Sink final : public FrameSink {
 public:
  /// `trigger`: path of a TriggerInput; each frame waits for it. Empty: frames go out when the player says so, and since nobody
  /// can see whether there is a reader, every one counts as sent.
  V4l2Sink(std::string device, std::string trigger);
  V4l2Sink(const V4l2Sink&) = delete;
  V4l2Sink& operator=(const V4l2Sink&) = delete;
  ~V4l2Sink() override { unplug(); }

  /// Throws InputError: no such device, none of v4l2loopback's, busy, or a reader holds another size or format.
  void plug(const FrameShape& shape) override;
  void unplug() override;
  bool write(const ServedFrame& frame, Duration wait) override;

 private:
  struct Mapping {
    void* start = nullptr;
    std::size_t bytes = 0;
    std::uint32_t offset = 0;  ///< by which the driver names it
  };
  void set_format(const FrameShape& shape);
  void map_buffers();
  void send(const ServedFrame& frame);
  [[noreturn]] void fail(const std::string& problem, const std::string& expected);

  std::string device_;
  TriggerInput trigger_;
  int fd_ = -1;
  std::vector<Mapping> mappings_;
  std::uint32_t next_ = 0;  ///< index of the buffer to fill
  std::size_t frame_bytes_ = 0;
};

}  // namespace relnav::hil
