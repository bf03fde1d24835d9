#include "platform/mps2/semihosted_camera.hpp"

#include <algorithm>
#include <span>

namespace relnav::platform::mps2 {
namespace {

template <typename Object>
Status read_object(HostFile& file, std::uint64_t offset, Object& object) {
  if (offset > file.size()) return Status::incomplete;
  return file.read(static_cast<std::uint32_t>(offset), {reinterpret_cast<std::uint8_t*>(&object), sizeof object});
}

}  // namespace

bool SemihostedCamera::read_header() {
  hal::raw::FileHeader header;
  if (read_object(file_, 0, header) != Status::ok || !is_whole(header)) return false;
  header_ = header;
  return true;
}

Status SemihostedCamera::start() {
  streaming_ = false;
  if (!file_.is_open() && file_.open(path_, HostFile::Access::read) != Status::ok) return Status::device_lost;
  if (!read_header()) return Status::device_lost;
  streaming_ = true;
  return Status::ok;
}

Status SemihostedCamera::stop() {
  streaming_ = false;
  return Status::ok;
}

std::uint32_t SemihostedCamera::frames_done() const {
  const auto out = std::count_if(leases_.begin(), leases_.end(), [](std::uint32_t lease) { return lease != 0; });
  return next_ - static_cast<std::uint32_t>(out);
}

Status SemihostedCamera::transfer(std::uint32_t number, FrameMemory& memory, hal::raw::FrameHeader& header) {
  std::uint64_t offset = 0;
  if (read_object(file_, header_.index_offset + std::uint64_t{number} * sizeof offset, offset) != Status::ok ||
      read_object(file_, offset, header) != Status::ok || !is_whole(header) || header.status != 0 ||
      header.pixel_bytes == 0 || header.pixel_bytes > memory.size()) {
    return Status::incomplete;
  }
  const std::span pixels(memory.data(), header.pixel_bytes);
  if (file_.read(static_cast<std::uint32_t>(offset) + sizeof header, pixels) != Status::ok) return Status::incomplete;
  return crc32(pixels) == header.pixel_crc ? Status::ok : Status::incomplete;
}

Status SemihostedCamera::acquire(Duration, hal::Frame& frame) {
  if (!streaming_) return Status::not_configured;
  const auto lease = std::find(leases_.begin(), leases_.end(), 0U);
  if (lease == leases_.end()) return Status::no_capacity;
  if (next_ >= header_.frames && (!read_header() || next_ >= header_.frames)) return Status::no_data;
  FrameMemory& memory = memory_[static_cast<std::size_t>(lease - leases_.begin())];
  hal::raw::FrameHeader header;
  const Status status = transfer(next_++, memory, header);
  if (status != Status::ok) return status;
  *lease = ++last_lease_;
  const bool deep = header.format == hal::PixelFormat::mono16;
  frame = {.pixels = memory.data(),
           .width_px = header.width_px,
           .height_px = header.height_px,
           .stride_bytes = header.width_px * (deep ? 2U : 1U),
           .format = header.format,
           .mid_exposure = {header.mid_exposure_ns},
           .first_data = {header.first_data_ns},
           .dequeued = {header.dequeued_ns},
           .clock = header.clock,
           .sequence = header.sequence,
           .exposure = {header.exposure_ns},
           .lease = *lease};
  return Status::ok;
}

Status SemihostedCamera::release(const hal::Frame& frame) {
  const auto lease = std::find(leases_.begin(), leases_.end(), frame.lease);
  if (frame.lease == 0 || lease == leases_.end()) return Status::stale_handle;
  *lease = 0;
  return Status::ok;
}

}  // namespace relnav::platform::mps2
