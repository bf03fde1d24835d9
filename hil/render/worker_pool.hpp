#pragma once
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace relnav::hil {

/// Threads that wait for work; who calls works along.
class WorkerPool {
 public:
  /// `threads`: with the caller's, at least 1.
  explicit WorkerPool(std::size_t threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// `work` of 0 .. count - 1, in any order and on any thread; returns when all is done. `work` must not throw.
  void run(std::size_t count, const std::function<void(std::size_t)>& work);

 private:
  void wait_for_work();
  void take_part();

  std::mutex mutex_;
  std::condition_variable begun_;
  std::condition_variable done_;
  const std::function<void(std::size_t)>* work_ = nullptr;
  std::size_t count_ = 0;
  std::atomic<std::size_t> next_{0};
  std::size_t round_ = 0;
  std::size_t busy_ = 0;
  bool ends_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace relnav::hil
