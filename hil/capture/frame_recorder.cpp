#include "hil/capture/frame_recorder.hpp"

#include <algorithm>
#include <chrono>
#include <exception>

namespace relnav::hil {
namespace {

std::int64_t steady_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

FrameRecorder::FrameRecorder(RawContainerWriter& writer, std::size_t room)
    : writer_(writer), room_(room), thread_([this] { run(); }) {}

bool FrameRecorder::offer(const hal::Frame& frame, double gain) {
  {
    const std::lock_guard lock(mutex_);
    if (closing_ || !problem_.empty() || unwritten_ >= room_) return false;
    waiting_.push_back({frame, gain});
    counts_.most_waiting = std::max(counts_.most_waiting, ++unwritten_);
  }
  changed_.notify_one();
  return true;
}

std::optional<hal::Frame> FrameRecorder::take_back() {
  const std::lock_guard lock(mutex_);
  if (done_.empty()) return std::nullopt;
  const hal::Frame frame = done_.front();
  done_.pop_front();
  return frame;
}

void FrameRecorder::finish() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();
}

FrameRecorder::Counts FrameRecorder::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

std::string FrameRecorder::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

void FrameRecorder::run() {
  std::vector<Item> items;
  while (true) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return closing_ || !waiting_.empty(); });
      if (waiting_.empty()) return;
      items.assign(waiting_.begin(), waiting_.end());
      waiting_.clear();
    }
    record(items);
  }
}

void FrameRecorder::record(const std::vector<Item>& items) {
  std::size_t written = 0;
  std::string problem = this->problem();  // after a failure nothing more is written, and leases only go back
  const std::int64_t start = steady_ns();
  for (const Item& item : items) {
    try {
      if (problem.empty()) {
        writer_.add(item.frame, item.gain);
        ++written;
      }
    } catch (const std::exception& error) {
      problem = error.what();
    }
    const std::lock_guard lock(mutex_);
    --unwritten_;
    done_.push_back(item.frame);
  }
  const std::int64_t all_written = steady_ns();
  bool confirmed = false;
  try {
    if (written > 0) writer_.sync();
    confirmed = written > 0;
  } catch (const std::exception& error) {
    if (problem.empty()) problem = error.what();
  }
  const std::int64_t end = steady_ns();
  const std::lock_guard lock(mutex_);
  problem_ = problem;
  if (!confirmed) return;
  counts_.recorded += written;
  ++counts_.syncs;
  counts_.write_ns += all_written - start;
  counts_.sync_ns += end - all_written;
  counts_.longest_ns = std::max(counts_.longest_ns, end - start);
}

}  // namespace relnav::hil
