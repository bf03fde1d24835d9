#include "platform/linux/aravis_driver.hpp"

#include <arv.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>

#include "platform/linux/aravis_link.hpp"

namespace relnav::platform::linux {
namespace {

constexpr std::uint32_t most_loans = 8;
constexpr Duration longest_adjustment{20'000'000};

/// Buffers beside those on loan bridge the time in which nobody takes any: about 64 MiB of them.
std::uint32_t buffer_count(std::uint32_t payload_bytes) {
  constexpr std::uint32_t memory_bytes = 64U << 20U;
  return std::clamp(memory_bytes / std::max(payload_bytes, 1U), 2 * most_loans, 64U);
}

Time now(clockid_t clock) {
  timespec t{};
  ::clock_gettime(clock, &t);
  return {std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec};
}

/// The thread that receives packets goes before those that work on images. Where that is not allowed it stays as it is.
void on_stream_event(void*, ArvStreamCallbackType type, ArvBuffer*) {
  constexpr int niceness = -10;
  if (type == ARV_STREAM_CALLBACK_TYPE_INIT)
    static_cast<void>(::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), niceness));
}

}  // namespace

AravisDriver::~AravisDriver() { close(); }

Status AravisDriver::open(const CameraSettings& settings) {
  close();
  problem_.clear();
  name_ = "camera " + settings.device;
  applied_ = {};
  stamp_meaning_ = settings.stamp_meaning;
  Status status = connect(settings);
  if (status == Status::ok) status = check_serial(settings);
  if (status == Status::ok) status = push_settings(session_->camera(), settings, applied_, problem_);
  if (status == Status::ok) {
    // Asked before anything streams: with a camera that has vanished every question takes seconds.
    range_status_ = exposure_range_of(session_->camera(), range_);
    in_force_.restart({{static_cast<std::int64_t>(applied_.exposure_us * 1e3)}, applied_.gain});
    status = start_stream(settings);
  }
  if (status != Status::ok) close();
  return status;
}

Status AravisDriver::connect(const CameraSettings& settings) {
  AravisFailure failure;
  ArvDevice* device = nullptr;
  if (is_ipv4_address(settings.device)) {
    std::string ours;
    const Status found = find_gige_camera(settings.device, ours);
    if (found != Status::ok) {
      problem_ = name_ + ": nothing answers there (expected a GigE Vision camera)";
      return found;
    }
    GInetAddress* const from = g_inet_address_new_from_string(ours.c_str());
    GInetAddress* const to = g_inet_address_new_from_string(settings.device.c_str());
    device = arv_gv_device_new(from, to, failure);
    g_object_unref(from);
    g_object_unref(to);
  } else {
    device = arv_open_device(settings.device.empty() ? nullptr : settings.device.c_str(), failure);
  }
  if (device == nullptr) {
    const bool absent = failure.status() == Status::ok || failure.status() == Status::no_data;
    problem_ = name_ +
               (absent ? std::string(": there is none") : std::string(": cannot be opened: ") + failure.text()) +
               " (expected a name, serial number or address of a camera)";
    return absent ? Status::no_data : failure.status();
  }
  ArvCamera* const camera = arv_camera_new_with_device(device, failure);
  const bool controls = !ARV_IS_GV_DEVICE(device) || arv_gv_device_is_controller(ARV_GV_DEVICE(device));
  g_object_unref(device);  // the camera has it
  if (camera == nullptr) {
    problem_ = name_ + ": " + failure.text() + " (expected a camera)";
    return failure.happened() ? failure.status() : Status::unsupported;
  }
  session_ = std::make_unique<AravisSession>(camera);
  if (!controls) {
    problem_ = name_ + ": busy, somebody else controls it (expected a free camera)";
    return Status::no_capacity;
  }
  return Status::ok;
}

Status AravisDriver::check_serial(const CameraSettings& settings) {
  if (settings.serial.empty()) return Status::ok;
  AravisFailure failure;
  const char* const serial = arv_camera_get_device_serial_number(session_->camera(), failure);
  if (serial != nullptr && settings.serial == serial) return Status::ok;
  problem_ = name_ + ": its serial number is " + (serial != nullptr ? serial : "not known") + " (expected " +
             settings.serial + ")";
  return Status::unsupported;
}

Status AravisDriver::start_stream(const CameraSettings& settings) {
  ArvCamera* const camera = session_->camera();
  AravisFailure failure;
  const auto failed = [&](const char* what) {
    problem_ = name_ + ": " + what + ": " + failure.text() + " (expected a camera that streams)";
    return failure.happened() ? failure.status() : Status::io_error;
  };
  const bool gige = arv_camera_is_gv_device(camera) != 0;
  if (gige) {
    // A packet socket sees nothing on the loopback interface, and one is only tried by the privileged.
    arv_camera_gv_set_stream_options(camera, ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
    arv_camera_gv_set_packet_size_adjustment(camera, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
    if (settings.packet_bytes != 0) {
      arv_camera_gv_set_packet_size(camera, static_cast<gint>(settings.packet_bytes), failure);
      if (failure.happened()) return failed("the packet size is not accepted");
    } else {
      arv_camera_gv_auto_packet_size(camera, failure);  // one that cannot negotiate keeps its size
    }
  }
  const std::uint32_t payload = arv_camera_get_payload(camera, failure);
  if (failure.happened() || payload == 0) return failed("the payload size is not known");
  ArvStream* const stream = arv_camera_create_stream(camera, on_stream_event, nullptr, failure);
  if (stream == nullptr) return failed("no stream can be opened");
  if (gige) {
    const std::uint32_t bytes = settings.socket_buffer_bytes != 0 ? settings.socket_buffer_bytes : 2 * payload;
    const Status set = set_receive_buffer(arv_gv_stream_get_port(ARV_GV_STREAM(stream)), bytes);
    // Of size 0: Aravis keeps its hands off it.
    g_object_set(stream, "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED, "socket-buffer-size",
                 set == Status::ok ? 0 : static_cast<gint>(bytes), nullptr);
  }
  session_->add_stream(stream, buffer_count(payload), payload);
  on_loan_.assign(session_->buffer_count(), false);
  counter_ = BlockIdCounter(gige ? 1 : 0);
  arv_camera_start_acquisition(camera, failure);
  if (failure.happened()) return failed("it does not start");
  return Status::ok;
}

void AravisDriver::close() {
  if (!session_) return;
  const bool answers = session_->answers();
  std::future<void> end = AravisSession::end(std::move(session_), answers);
  if (answers) return end.wait();
  constexpr std::size_t most_former = 16;
  std::erase_if(former_,
                [](const auto& f) { return f.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
  if (former_.size() == most_former) former_.erase(former_.begin());  // waits for it
  former_.push_back(std::move(end));
}

Status AravisDriver::take(Duration wait, RawImage& image) {
  if (!session_) return Status::not_configured;
  const bool waits = wait.ns > 0 && !session_->is_lost();
  ArvBuffer* const buffer =
      waits ? arv_stream_timeout_pop_buffer(session_->stream(), static_cast<guint64>(wait.ns) / 1000)
            : arv_stream_try_pop_buffer(session_->stream());
  if (buffer == nullptr) {
    if (session_->is_lost()) {
      problem_ = name_ + ": it does not answer any more, or somebody else controls it (expected it to stay)";
      return Status::device_lost;
    }
    return waits ? Status::timeout : Status::no_data;
  }
  describe(buffer, image);
  on_loan_[image.buffer] = true;
  return Status::ok;
}

void AravisDriver::describe(ArvBuffer* buffer, RawImage& image) {
  image = {};
  image.buffer = GPOINTER_TO_UINT(arv_buffer_get_user_data(buffer));
  image.dequeued = now(CLOCK_MONOTONIC);
  // Aravis takes the arrival from CLOCK_REALTIME.
  const Duration to_monotonic = image.dequeued - now(CLOCK_REALTIME);
  image.first_data = Time{static_cast<std::int64_t>(arv_buffer_get_system_timestamp(buffer))} + to_monotonic;
  image.format = applied_.format;
  image.width_px = applied_.width_px;
  image.height_px = applied_.height_px;
  image.stride_bytes = applied_.width_px * applied_.bits_per_pixel / 8;
  take_adjusted();
  // The first packet comes when the exposure is over, and not sooner than that.
  const ExposureInForce::Values& exposure = in_force_.at(image.first_data, StampMeaning::end_of_exposure);
  image.exposure = exposure.exposure;
  image.gain = exposure.gain;
  image.stamp_meaning = stamp_meaning_;
  image.has_sequence = true;
  const std::uint64_t stamp_ns = arv_buffer_get_timestamp(buffer);
  image.clock = stamp_ns != 0 ? hal::ClockId::device : hal::ClockId::monotonic;
  image.stamp = stamp_ns != 0 ? Time{static_cast<std::int64_t>(stamp_ns)} : image.first_data;
  // A buffer that no leader came for still bears number and stamp of the frame that it held before.
  if (arv_buffer_get_status(buffer) != ARV_BUFFER_STATUS_SUCCESS || arv_buffer_get_n_parts(buffer) == 0) return;
  image.sequence = counter_.count(arv_buffer_get_frame_id(buffer));
  gint padding = 0;
  gint lines_padding = 0;
  arv_buffer_get_image_padding(buffer, &padding, &lines_padding);
  image.stride_bytes += static_cast<std::uint32_t>(padding);
  image.width_px = static_cast<std::uint32_t>(arv_buffer_get_image_width(buffer));
  image.height_px = static_cast<std::uint32_t>(arv_buffer_get_image_height(buffer));
  std::size_t size = 0;
  const void* const pixels = arv_buffer_get_image_data(buffer, &size);
  image.bytes = {static_cast<const std::uint8_t*>(pixels), size};
  // Somebody may have told the camera another size or format since: such an image is none of ours.
  image.complete = pixels != nullptr && image.width_px == applied_.width_px && image.height_px == applied_.height_px &&
                   arv_buffer_get_image_pixel_format(buffer) == applied_.pixel_format &&
                   size >= std::size_t{image.stride_bytes} * image.height_px;
}

Status AravisDriver::give_back(std::uint32_t buffer) {
  if (!session_ || buffer >= on_loan_.size() || !on_loan_[buffer]) return Status::stale_handle;
  on_loan_[buffer] = false;
  arv_stream_push_buffer(session_->stream(), session_->buffer(buffer));
  return Status::ok;
}

Status AravisDriver::trigger() {
  if (!session_) return Status::not_configured;
  if (session_->is_lost()) return Status::device_lost;
  session_->trigger();
  return Status::ok;
}

Status AravisDriver::exposure_range(ExposureRange& range) {
  if (!session_) return Status::not_configured;
  if (session_->is_lost()) return Status::device_lost;
  if (range_status_ == Status::ok) {
    range = range_;
  } else {
    problem_ = name_ + ": it has no exposure time to set (expected one, for automatic exposure)";
  }
  return range_status_;
}

void AravisDriver::note(const AravisSession::Adjusted& adjusted) {
  if (adjusted.status != Status::ok) return;
  in_force_.change(adjusted.time, {{static_cast<std::int64_t>(adjusted.values.exposure_us * 1e3)},
                                   std::max(adjusted.values.gain, 0.0)});
}

void AravisDriver::take_adjusted() {
  AravisSession::Adjusted adjusted;
  if (session_->take_adjusted(adjusted)) note(adjusted);
}

Status AravisDriver::adjust(ExposureValues& values) {
  if (!session_) return Status::not_configured;
  if (session_->is_lost()) return Status::device_lost;
  if (range_status_ != Status::ok) return range_status_;
  take_adjusted();
  AravisSession::Adjusted adjusted;
  if (!session_->adjust(values, longest_adjustment, adjusted)) {
    problem_ = name_ + ": it does not answer to another exposure (expected an answer within 20 ms)";
    return Status::timeout;
  }
  if (adjusted.status != Status::ok) {
    problem_ = name_ + ": the exposure is not accepted (expected a camera that takes it while it streams)";
    return session_->is_lost() ? Status::device_lost : Status::io_error;
  }
  note(adjusted);
  values = adjusted.values;
  return Status::ok;
}

std::uint32_t AravisDriver::max_loans() const { return most_loans; }

std::uint64_t AravisDriver::underruns() const {
  guint64 completed = 0;
  guint64 failures = 0;
  guint64 underruns = 0;
  if (session_ && session_->stream() != nullptr)
    arv_stream_get_statistics(session_->stream(), &completed, &failures, &underruns);
  return underruns;
}

}  // namespace relnav::platform::linux
