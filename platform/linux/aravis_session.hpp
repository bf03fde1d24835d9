#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "platform/linux/camera_driver.hpp"

typedef struct _ArvBuffer ArvBuffer;
typedef struct _ArvCamera ArvCamera;
typedef struct _ArvDevice ArvDevice;
typedef struct _ArvStream ArvStream;

namespace relnav::platform::linux {

/// An open camera, its stream, and a thread that speaks to it while it streams: with a camera that has vanished every sentence
/// takes three seconds, and taking Aravis' objects down ten.
class AravisSession {
 public:
  /// Takes `camera` over.
  explicit AravisSession(ArvCamera* camera);
  AravisSession(const AravisSession&) = delete;
  AravisSession& operator=(const AravisSession&) = delete;
  ~AravisSession();

  [[nodiscard]] ArvCamera* camera() const { return camera_; }
  [[nodiscard]] ArvStream* stream() const { return stream_; }
  /// Takes `stream` over and gives it `count` buffers of `payload_bytes`; their user data is their number.
  void add_stream(ArvStream* stream, std::uint32_t count, std::uint32_t payload_bytes);
  [[nodiscard]] ArvBuffer* buffer(std::uint32_t number) const { return buffers_[number]; }
  [[nodiscard]] std::uint32_t buffer_count() const { return static_cast<std::uint32_t>(buffers_.size()); }

  /// The camera has left, as Aravis' heartbeat or a trigger without answer found.
  [[nodiscard]] bool is_lost() const { return lost_; }
  /// Sends a software trigger, later: never blocks.
  void trigger();

  /// What came of an adjust().
  struct Adjusted {
    std::uint32_t number = 0;
    Status status = Status::ok;
    ExposureValues values;
    Time time;  ///< CLOCK_MONOTONIC, when the camera had it
  };
  /// Sends these, and waits for the answer at most so long. False: it has not come yet; take_adjusted() gives it.
  [[nodiscard]] bool adjust(const ExposureValues& values, Duration wait, Adjusted& adjusted);
  /// True, once for an answer that came late.
  [[nodiscard]] bool take_adjusted(Adjusted& adjusted);

  /// Takes everything down in a thread of its own: at once where the camera answers, in up to 10 s where it does not. `stop`: it
  /// is told to stop; not for one that has vanished, as somebody else may use it when it is back.
  static std::future<void> end(std::unique_ptr<AravisSession> session, bool stop);
  /// For a camera on a network: whether it answers now (at most 0.3 s). Any other: whether it is not lost.
  [[nodiscard]] bool answers() const;

 private:
  static void on_control_lost(ArvDevice* device, void* session);
  void run();
  void send_trigger();
  void take_down();

  ArvCamera* camera_;
  ArvStream* stream_ = nullptr;
  std::vector<ArvBuffer*> buffers_;
  std::atomic<bool> lost_ = false;
  std::mutex mutex_;
  std::condition_variable asked_;
  bool trigger_asked_ = false;
  std::condition_variable answered_;
  bool adjust_asked_ = false;
  std::uint32_t adjust_number_ = 0;
  ExposureValues wanted_;
  bool has_adjusted_ = false;
  Adjusted adjusted_;
  bool stop_ = false;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace relnav::platform::linux
