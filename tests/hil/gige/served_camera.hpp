#pragma once
#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "hil/serve/frame_player.hpp"
#include "hil/serve/gige_server.hpp"
#include "platform/linux/camera_driver.hpp"
#include "tests/hil/gige/own_network.hpp"

namespace relnav {

inline constexpr const char* served_address = "127.0.0.1";
inline constexpr const char* served_serial = "RN01";
inline constexpr const char* lights_mono = RELNAV_SOURCE_DIR "/hil/captures/lights_mono/mav0/cam0";

/// Frames out of nothing, so that rates do not depend on a disk: pixel i of frame k is k + i, in 8 bits.
class CountedFrames final : public hil::FrameSource {
 public:
  CountedFrames(std::uint32_t width_px, std::uint32_t height_px, std::size_t count, double rate_hz)
      : shape_{width_px, height_px, 1}, count_(count), step_ns_(static_cast<std::int64_t>(1e9 / rate_hz)) {
    for (std::size_t k = 0; k < kinds; ++k) {
      auto image = std::make_shared<hil::Image>(hil::Image{width_px, height_px, 1, {}});
      image->bytes.resize(std::size_t{width_px} * height_px);
      for (std::size_t i = 0; i < image->bytes.size(); ++i) image->bytes[i] = static_cast<std::uint8_t>(k + i);
      images_[k] = image;
    }
  }
  [[nodiscard]] std::size_t count() const override { return count_; }
  [[nodiscard]] hil::FrameShape shape() const override { return shape_; }
  [[nodiscard]] Time stamp(std::size_t index) const override {
    return {1'000'000'000'000 + static_cast<std::int64_t>(index) * step_ns_};
  }
  std::shared_ptr<const hil::Image> image(std::size_t index) override { return images_[index % kinds]; }
  /// Which frame a stamp belongs to.
  [[nodiscard]] std::int64_t index_of(Time stamp) const { return (stamp.ns - 1'000'000'000'000) / step_ns_; }

 private:
  static constexpr std::size_t kinds = 8;
  hil::FrameShape shape_;
  std::size_t count_;
  std::int64_t step_ns_;
  std::shared_ptr<const hil::Image> images_[kinds];
};

/// A source played by a server in a thread of its own, until this is destroyed.
class ServedCamera {
 public:
  ServedCamera(hil::FrameSource& source, hil::PlayerSettings settings)
      : server_({served_address, served_serial}, settings.speed <= 0.0,
                [](const std::string& line) { std::printf("%s\n", line.c_str()); }),
        player_(source, std::move(settings)) {
    enter_own_network();
    thread_ = std::thread([this] {
      try {
        played_ = player_.play(server_, [this] { return stop_.load(); });
      } catch (const std::exception& error) {
        std::printf("%s\n", error.what());
        failed_ = true;
      }
      done_ = true;
    });
  }
  ServedCamera(const ServedCamera&) = delete;
  ServedCamera& operator=(const ServedCamera&) = delete;
  ~ServedCamera() { static_cast<void>(finish()); }

  /// Ends playing.
  hil::PlayedFrames finish() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return played_;
  }
  [[nodiscard]] bool is_done() const { return done_; }
  [[nodiscard]] bool failed() const { return failed_; }

 private:
  hil::GigeServer server_;
  hil::FramePlayer player_;
  hil::PlayedFrames played_;
  std::atomic<bool> stop_ = false;
  std::atomic<bool> done_ = false;
  std::atomic<bool> failed_ = false;
  std::thread thread_;
};

inline platform::linux::CameraSettings settings_for(std::uint32_t width_px, std::uint32_t height_px) {
  platform::linux::CameraSettings settings;
  settings.device = served_address;
  settings.serial = served_serial;
  settings.width_px = width_px;
  settings.height_px = height_px;
  settings.format = "grey8";
  settings.original_stamps = true;
  settings.packet_bytes = 8000;
  settings.socket_buffer_bytes = 4U << 20U;
  return settings;
}

/// Tries for some seconds: the server's thread is only just starting.
inline Status open_soon(platform::linux::CameraDriver& driver, const platform::linux::CameraSettings& settings) {
  Status status = Status::no_data;
  for (int i = 0; i < 50 && status == Status::no_data; ++i) {
    status = driver.open(settings);
    if (status == Status::no_data) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return status;
}

}  // namespace relnav
