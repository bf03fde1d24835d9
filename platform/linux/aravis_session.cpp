#include "platform/linux/aravis_session.hpp"

#include <arv.h>
#include <time.h>

#include <chrono>
#include <utility>

#include "platform/linux/aravis_link.hpp"
#include "platform/linux/aravis_settings.hpp"

namespace relnav::platform::linux {

AravisSession::AravisSession(ArvCamera* camera) : camera_(camera) {
  g_signal_connect(arv_camera_get_device(camera_), "control-lost", G_CALLBACK(&AravisSession::on_control_lost), this);
  thread_ = std::thread([this] { run(); });
}

AravisSession::~AravisSession() {
  if (thread_.joinable()) {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    asked_.notify_one();
    thread_.join();
  }
  take_down();
}

void AravisSession::add_stream(ArvStream* stream, std::uint32_t count, std::uint32_t payload_bytes) {
  stream_ = stream;
  buffers_.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    ArvBuffer* const buffer = arv_buffer_new_full(payload_bytes, nullptr, GUINT_TO_POINTER(i), nullptr);
    g_object_ref(buffer);  // one for the stream, one for us
    buffers_.push_back(buffer);
    arv_stream_push_buffer(stream_, buffer);
  }
}

void AravisSession::trigger() {
  {
    const std::lock_guard lock(mutex_);
    trigger_asked_ = true;
  }
  asked_.notify_one();
}

bool AravisSession::adjust(const ExposureValues& values, Duration wait, Adjusted& adjusted) {
  std::unique_lock lock(mutex_);
  wanted_ = values;
  adjust_asked_ = true;
  const std::uint32_t number = ++adjust_number_;
  asked_.notify_one();
  const bool answered = answered_.wait_for(lock, std::chrono::nanoseconds(wait.ns),
                                           [this, number] { return has_adjusted_ && adjusted_.number == number; });
  if (!answered) return false;
  has_adjusted_ = false;
  adjusted = adjusted_;
  return true;
}

bool AravisSession::take_adjusted(Adjusted& adjusted) {
  const std::lock_guard lock(mutex_);
  if (!has_adjusted_) return false;
  has_adjusted_ = false;
  adjusted = adjusted_;
  return true;
}

void AravisSession::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    asked_.wait(lock, [this] { return ending_ || trigger_asked_ || adjust_asked_; });
    if (ending_) return;
    const bool triggers = std::exchange(trigger_asked_, false);
    const bool adjusts = std::exchange(adjust_asked_, false);
    Adjusted adjusted;
    adjusted.number = adjust_number_;
    adjusted.values = wanted_;
    lock.unlock();
    if (triggers) send_trigger();
    if (adjusts) {
      adjusted.status = lost_ ? Status::device_lost : push_exposure(camera_, adjusted.values);
      timespec now{};
      ::clock_gettime(CLOCK_MONOTONIC, &now);
      adjusted.time = {std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec};
    }
    lock.lock();
    if (adjusts) {
      adjusted_ = adjusted;
      has_adjusted_ = true;
      answered_.notify_one();
    }
  }
}

void AravisSession::send_trigger() {
  if (lost_) return;
  AravisFailure failure;
  arv_camera_software_trigger(camera_, failure);
  if (failure.happened()) lost_ = true;
}

std::future<void> AravisSession::end(std::unique_ptr<AravisSession> session, bool stop) {
  session->stop_ = stop;
  return std::async(std::launch::async, [owned = std::move(session)]() mutable { owned.reset(); });
}

void AravisSession::take_down() {
  g_signal_handlers_disconnect_by_data(arv_camera_get_device(camera_), this);
  AravisFailure failure;
  if (stream_ != nullptr && stop_) arv_camera_stop_acquisition(camera_, failure);
  if (stream_ != nullptr) {
    // The buffers go before all that waits. Aravis stops the thread once more, and complains where there is none.
    arv_stream_stop_thread(stream_, TRUE);
    arv_stream_start_thread(stream_);
  }
  for (ArvBuffer* const buffer : buffers_) g_object_unref(buffer);
  g_clear_object(&stream_);
  g_clear_object(&camera_);
}

bool AravisSession::answers() const {
  ArvDevice* const device = arv_camera_get_device(camera_);
  if (!ARV_IS_GV_DEVICE(device)) return !lost_;
  GSocketAddress* const address = arv_gv_device_get_device_address(ARV_GV_DEVICE(device));
  char* const text = g_inet_address_to_string(g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(address)));
  std::string ours;
  const bool there = find_gige_camera(text, ours) == Status::ok;
  g_free(text);
  return there;
}

void AravisSession::on_control_lost(ArvDevice*, void* session) { static_cast<AravisSession*>(session)->lost_ = true; }

}  // namespace relnav::platform::linux
