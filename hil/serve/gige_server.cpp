#include "hil/serve/gige_server.hpp"

#include <arpa/inet.h>
#include <arv.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

static_assert(std::endian::native == std::endian::little, "GVSP sends Mono16 with the lower byte first");

constexpr unsigned block_ids = 65535;
/// As long as the fake camera may be kept from its other duty, to answer on the control channel.
constexpr std::chrono::milliseconds most_wait{250};
constexpr unsigned longest_serial = 15;

unsigned read_register(ArvFakeCamera* camera, unsigned address) {
  guint32 value = 0;
  arv_fake_camera_read_register(camera, address, &value);
  return value;
}

/// Why a control channel cannot be opened at `address`; 0: it can. Aravis would share the port with whoever has it.
int reason_against(const std::string& address) {
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(3956);
  static_cast<void>(::inet_pton(AF_INET, address.c_str(), &place.sin_addr));
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const int reason = ::bind(socket, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0 ? 0 : errno;
  ::close(socket);
  return reason;
}

}  // namespace

GigeServer::Place GigeServer::parse_place(const std::string& text) {
  const auto parts = split(text, ',');
  Place place;
  place.address = std::string(parts[0]);
  if (parts.size() > 1) place.serial = std::string(parts[1]);
  in_addr address{};
  if (parts.size() > 2 || ::inet_pton(AF_INET, place.address.c_str(), &address) != 1 || place.serial.empty() ||
      place.serial.size() > longest_serial) {
    throw InputError("--gige " + in_quotes(text), 0, "is no place for a camera",
                     "ADDRESS[,SERIAL]: an IPv4 address of this machine, a number of at most 15 characters");
  }
  return place;
}

GigeServer::GigeServer(Place place, bool lock_step, std::function<void(const std::string&)> log)
    : place_(std::move(place)), lock_step_(lock_step), log_(std::move(log)) {}

void GigeServer::plug(const FrameShape& shape) {
  unplug();
  if (shape.width_px > ARV_FAKE_CAMERA_SENSOR_WIDTH || shape.height_px > ARV_FAKE_CAMERA_SENSOR_HEIGHT) {
    throw InputError("--gige " + place_.address, 0, format_text("%u x %u pixels", shape.width_px, shape.height_px),
                     format_text("at most %u x %u", ARV_FAKE_CAMERA_SENSOR_WIDTH, ARV_FAKE_CAMERA_SENSOR_HEIGHT));
  }
  shape_ = shape;
  leaving_ = false;
  const int reason = reason_against(place_.address);
  if (reason != 0) {
    throw InputError("--gige " + place_.address, 0, std::string("cannot be listened on: ") + std::strerror(reason),
                     "the address of an interface of this machine, its port 3956 free");
  }
  server_ = arv_gv_fake_camera_new(place_.address.c_str(), place_.serial.c_str());
  if (server_ == nullptr || !arv_gv_fake_camera_is_running(server_)) {
    g_clear_object(&server_);
    throw InputError("--gige " + place_.address, 0, "cannot be listened on",
                     "the address of an interface of this machine, its port 3956 free");
  }
  camera_ = arv_gv_fake_camera_get_fake_camera(server_);
  arv_fake_camera_set_fill_pattern(camera_, on_fill, this);
  arv_fake_camera_set_trigger_frequency(camera_, 1000.0);
  arv_fake_camera_write_register(camera_, ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, shape.width_px);
  arv_fake_camera_write_register(camera_, ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, shape.height_px);
  arv_fake_camera_write_register(camera_, ARV_FAKE_CAMERA_REGISTER_WIDTH, shape.width_px);
  arv_fake_camera_write_register(camera_, ARV_FAKE_CAMERA_REGISTER_HEIGHT, shape.height_px);
  arv_fake_camera_write_register(camera_, ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT,
                                 shape.bytes_per_pixel == 2 ? ARV_PIXEL_FORMAT_MONO_16 : ARV_PIXEL_FORMAT_MONO_8);
  // The player sets the pace; the fake camera only asks often enough.
  arv_fake_camera_write_register(camera_, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, 1000);
}

void GigeServer::unplug() {
  if (server_ == nullptr) return;
  {
    const std::lock_guard lock(mutex_);
    leaving_ = true;
  }
  changed_.notify_all();
  // No frame begins any more, and none is being filled: setting the pattern waits for that. Then its thread is joined.
  arv_fake_camera_write_register(camera_, ARV_FAKE_CAMERA_REGISTER_ACQUISITION, 0);
  arv_fake_camera_set_fill_pattern(camera_, on_fill, this);
  g_object_unref(server_);
  server_ = nullptr;
  camera_ = nullptr;
}

bool GigeServer::write(const ServedFrame& frame, Duration wait) {
  std::unique_lock lock(mutex_);
  offered_ = &frame;
  taken_ = false;
  changed_.notify_all();
  changed_.wait_for(lock, std::chrono::nanoseconds(wait.ns), [this] { return taken_; });
  offered_ = nullptr;
  return taken_;
}

unsigned GigeServer::exposure_us() const {
  return camera_ == nullptr ? 0 : read_register(camera_, ARV_FAKE_CAMERA_REGISTER_EXPOSURE_TIME_US);
}

unsigned GigeServer::raw_gain() const {
  return camera_ == nullptr ? 0 : read_register(camera_, ARV_FAKE_CAMERA_REGISTER_GAIN_RAW);
}

void GigeServer::on_fill(ArvBuffer* buffer, void* server, unsigned, unsigned, unsigned pixel_format) {
  static_cast<GigeServer*>(server)->fill(buffer, pixel_format);
}

void GigeServer::fill(ArvBuffer* buffer, unsigned pixel_format) {
  lose_packets(1.0);  // nothing is sent unless there is something to send
  if (!can_serve(pixel_format)) return;
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, most_wait, [this] { return leaving_ || (offered_ != nullptr && !taken_); });
  if (leaving_ || offered_ == nullptr || taken_) return;
  const ServedFrame& frame = *offered_;
  if (!frame.lost) {
    copy_pixels(*frame.image, buffer, pixel_format);
    arv_buffer_set_timestamp(buffer, static_cast<guint64>(frame.stamp.ns));
    arv_buffer_set_frame_id(buffer, frame.number % block_ids + 1);
    lose_packets(frame.packets_lost_per_mille / 1000.0);
  }
  taken_ = true;
  changed_.notify_all();
}

bool GigeServer::can_serve(unsigned pixel_format) {
  if (lock_step_ && !arv_fake_camera_is_in_software_trigger_mode(camera_)) {
    say_once("the client lets the camera run free (expected software triggers: lock step)");
    std::this_thread::sleep_for(most_wait);
    return false;
  }
  switch (pixel_format) {
    case ARV_PIXEL_FORMAT_MONO_8:
    case ARV_PIXEL_FORMAT_MONO_16:
    case ARV_PIXEL_FORMAT_BAYER_GR_8:
    case ARV_PIXEL_FORMAT_BAYER_RG_8:
    case ARV_PIXEL_FORMAT_BAYER_GB_8:
    case ARV_PIXEL_FORMAT_BAYER_BG_8: return true;
    default: break;
  }
  say_once(format_text("the client wants pixel format 0x%08x (expected Mono8, Mono16 or Bayer..8)", pixel_format));
  std::this_thread::sleep_for(most_wait);
  return false;
}

void GigeServer::copy_pixels(const Image& image, ArvBuffer* buffer, unsigned pixel_format) const {
  const unsigned width = read_register(camera_, ARV_FAKE_CAMERA_REGISTER_WIDTH);
  const unsigned height = read_register(camera_, ARV_FAKE_CAMERA_REGISTER_HEIGHT);
  const unsigned left = read_register(camera_, ARV_FAKE_CAMERA_REGISTER_X_OFFSET);
  const unsigned top = read_register(camera_, ARV_FAKE_CAMERA_REGISTER_Y_OFFSET);
  // The buffer is the fake camera's own, of as many bytes as its payload says; it wants to be filled here.
  auto* const pixels = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, nullptr)));
  const std::size_t payload = arv_fake_camera_get_payload(camera_);
  const unsigned depth = pixel_format == ARV_PIXEL_FORMAT_MONO_16 ? 2 : 1;
  if (std::size_t{width} * height * depth > payload) return;
  std::memset(pixels, 0, payload);
  if (left >= image.width_px || top >= image.height_px) return;
  const std::size_t columns = std::min(width, image.width_px - left);
  const std::size_t rows = std::min(height, image.height_px - top);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::uint8_t* const from = image.bytes.data() + ((top + row) * image.width_px + left) * image.bytes_per_pixel;
    std::uint8_t* const to = pixels + row * width * depth;
    if (depth == image.bytes_per_pixel) {
      std::memcpy(to, from, columns * depth);
    } else if (depth == 1) {
      for (std::size_t i = 0; i < columns; ++i) to[i] = from[2 * i + 1];
    } else {
      for (std::size_t i = 0; i < columns; ++i) to[2 * i + 1] = from[i];
    }
  }
}

void GigeServer::lose_packets(double ratio) { g_object_set(server_, "gvsp-lost-ratio", ratio, nullptr); }

void GigeServer::say_once(const std::string& line) {
  if (line == said_) return;
  said_ = line;
  if (log_) log_("--gige " + place_.address + ": " + line);
}

}  // namespace relnav::hil
