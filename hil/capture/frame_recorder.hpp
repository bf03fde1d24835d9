#pragma once
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hal/frame.hpp"
#include "hil/io/raw_container.hpp"

namespace relnav::hil {

/// Frames on their way to the disk: a bounded queue and a thread that writes. Frames are not copied: whoever offers one keeps
/// its lease until it comes back from take_back(). All that wait at a moment are written in a row and then confirmed by the disk
/// together (a disk confirms some hundred times a second at best); only then they count as recorded.
class FrameRecorder {
 public:
  struct Counts {
    std::uint64_t recorded = 0;  ///< confirmed by the disk
    std::uint64_t syncs = 0;
    std::int64_t write_ns = 0;  ///< checksum and writing, of all frames
    std::int64_t sync_ns = 0;
    std::int64_t longest_ns = 0;   ///< from taking up work to the disk's confirmation
    std::size_t most_waiting = 0;  ///< frames that were offered and not written yet
  };

  /// `room`: frames that may wait, the one that is being written included. `writer` is used by the thread until finish().
  FrameRecorder(RawContainerWriter& writer, std::size_t room);
  FrameRecorder(const FrameRecorder&) = delete;
  FrameRecorder& operator=(const FrameRecorder&) = delete;
  ~FrameRecorder() { finish(); }

  /// False: no room, or has_failed(); the frame is not taken then. `gain`: of the sensor; 0: not known.
  [[nodiscard]] bool offer(const hal::Frame& frame, double gain);
  /// The next frame whose pixels are not needed any more.
  [[nodiscard]] std::optional<hal::Frame> take_back();
  /// Waits until all that was offered is on the disk or has failed. Afterwards nothing is taken.
  void finish();

  [[nodiscard]] Counts counts() const;
  [[nodiscard]] bool has_failed() const { return !problem().empty(); }
  /// One line; empty: all is well.
  [[nodiscard]] std::string problem() const;

 private:
  struct Item {
    hal::Frame frame;
    double gain = 0.0;
  };
  void run();
  void record(const std::vector<Item>& items);

  RawContainerWriter& writer_;
  const std::size_t room_;
  mutable std::mutex mutex_;  ///< of all below
  std::condition_variable changed_;
  std::deque<Item> waiting_;
  std::deque<hal::Frame> done_;
  std::size_t unwritten_ = 0;
  bool closing_ = false;
  Counts counts_;
  std::string problem_;
  std::thread thread_;
};

}  // namespace relnav::hil
