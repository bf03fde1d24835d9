#include "hil/io/raw_container_reader.hpp"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hil/io/fast_crc32.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

constexpr std::uint32_t most_side_px = 16384;
constexpr std::size_t search_bytes = 1U << 20U;

unsigned long long printable(std::uint64_t number) { return number; }

bool is_sane(const hal::raw::FrameHeader& header) {
  return is_whole(header) && header.width_px >= 1 && header.height_px >= 1 && header.width_px <= most_side_px &&
         header.height_px <= most_side_px && header.format <= hal::PixelFormat::mono16 &&
         header.clock <= hal::ClockId::device;
}

}  // namespace

RawContainerReader::RawContainerReader(const std::string& path)
    : path_(path), file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  const char* const expectation = "a raw container, as relnav capture writes them";
  if (!file_.is_open())
    throw InputError(path, 0, std::string("cannot be opened: ") + std::strerror(errno), expectation);
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0 || !S_ISREG(status.st_mode))
    throw InputError(path, 0, "is no regular file", expectation);
  bytes_ = static_cast<std::uint64_t>(status.st_size);

  hal::raw::FileHeader header;
  const bool has_header = read(&header, sizeof header, 0) && is_whole(header);
  const bool finished = has_header && header.index_offset >= sizeof header && header.index_offset <= bytes_;
  if (finished && read_by_index(header)) return;
  const std::uint64_t end = search(finished ? header.index_offset : bytes_);
  if (finished) {
    notes_.push_back(path + ": the index is damaged; frames were searched for one by one");
    return;
  }
  std::array<std::uint8_t, sizeof header> begin{};
  const bool unwritten =
      read(begin.data(), static_cast<std::size_t>(std::min<std::uint64_t>(bytes_, begin.size())), 0) &&
      std::all_of(begin.begin(), begin.end(), [](std::uint8_t byte) { return byte == 0; });
  if (frames_.empty() && !has_header && !unwritten)
    throw InputError(path, 0, "has no file header and no frame", expectation);
  if (is_index(end)) {
    notes_.push_back(path + ": the file header is damaged; frames were searched for one by one");
    return;
  }
  cut_ = true;
  drop_unwritten();
  const std::uint64_t whole =
      frames_.empty() ? std::min<std::uint64_t>(sizeof header, bytes_)
                      : frames_.back().offset + sizeof(hal::raw::FrameHeader) + frames_.back().header.pixel_bytes;
  notes_.push_back(path +
                   format_text(": the recording was cut off: %zu whole frames, %llu bytes after them are of no use",
                               frames_.size(), printable(bytes_ - whole)));
}

bool RawContainerReader::read(void* bytes, std::size_t size, std::uint64_t offset) const {
  auto* to = static_cast<std::uint8_t*>(bytes);
  while (size > 0) {
    const ssize_t got = ::pread(file_.get(), to, size, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError(path_, 0, std::string("cannot be read: ") + std::strerror(errno), "a readable file");
    if (got == 0) return false;
    to += got;
    offset += static_cast<std::uint64_t>(got);
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

bool RawContainerReader::read_frame_header(std::uint64_t offset, std::uint64_t end, Place& place) const {
  place.offset = offset;
  return offset <= end && end - offset >= sizeof place.header && read(&place.header, sizeof place.header, offset) &&
         is_sane(place.header);
}

bool RawContainerReader::read_by_index(const hal::raw::FileHeader& header) {
  if (std::uint64_t{header.frames} * sizeof(std::uint64_t) > bytes_ - header.index_offset) return false;
  std::vector<std::uint64_t> offsets(header.frames);
  const std::size_t index_bytes = offsets.size() * sizeof(std::uint64_t);
  if (!read(offsets.data(), index_bytes, header.index_offset)) return false;
  if (fast_crc32({reinterpret_cast<const std::uint8_t*>(offsets.data()), index_bytes}) != header.index_crc)
    return false;
  frames_.reserve(offsets.size());
  for (std::size_t k = 0; k < offsets.size(); ++k) {
    Place place;
    if (read_frame_header(offsets[k], header.index_offset, place) &&
        header.index_offset - offsets[k] - sizeof place.header >= place.header.pixel_bytes) {
      frames_.push_back(place);
    } else {
      notes_.push_back(path_ + format_text(": the frame at byte %llu (%zu of %zu) has a damaged header and is left out",
                                           printable(offsets[k]), k + 1, offsets.size()));
    }
  }
  return true;
}

std::uint64_t RawContainerReader::search(std::uint64_t end) {
  std::uint64_t offset = sizeof(hal::raw::FileHeader);
  while (offset < end) {
    Place place;
    if (read_frame_header(offset, end, place)) {
      const std::uint64_t frame_bytes = sizeof place.header + std::uint64_t{place.header.pixel_bytes};
      if (frame_bytes > end - offset) break;
      frames_.push_back(place);
      offset += frame_bytes;
      continue;
    }
    const std::uint64_t next = next_frame(offset + 1, end);
    if (next == end) break;
    notes_.push_back(path_ + format_text(": bytes %llu to %llu hold no whole frame and are left out", printable(offset),
                                         printable(next)));
    offset = next;
  }
  return std::min(offset, end);
}

std::uint64_t RawContainerReader::next_frame(std::uint64_t offset, std::uint64_t end) const {
  const auto& magic = hal::raw::frame_magic;
  std::vector<char> window;
  while (offset < end && end - offset >= sizeof(hal::raw::FrameHeader)) {
    window.resize(static_cast<std::size_t>(std::min<std::uint64_t>(end - offset, search_bytes)));
    if (!read(window.data(), window.size(), offset)) break;
    auto at = window.begin();
    while ((at = std::search(at, window.end(), magic.begin(), magic.end())) != window.end()) {
      const std::uint64_t found = offset + static_cast<std::uint64_t>(at - window.begin());
      Place place;
      if (read_frame_header(found, end, place)) return found;
      ++at;
    }
    offset += window.size() - (magic.size() - 1);  // it may lie across two windows
  }
  return end;
}

bool RawContainerReader::is_index(std::uint64_t offset) const {
  const std::uint64_t left = bytes_ - std::min(offset, bytes_);
  if (left == 0 || left % sizeof(std::uint64_t) != 0 || left / sizeof(std::uint64_t) < frames_.size()) return false;
  std::vector<std::uint64_t> offsets(static_cast<std::size_t>(left / sizeof(std::uint64_t)));
  if (!read(offsets.data(), offsets.size() * sizeof(std::uint64_t), offset) ||
      !std::is_sorted(offsets.begin(), offsets.end()))
    return false;
  if (offsets.front() < sizeof(hal::raw::FileHeader) || offsets.back() >= offset) return false;
  return std::all_of(frames_.begin(), frames_.end(), [&](const Place& place) {
    return std::binary_search(offsets.begin(), offsets.end(), place.offset);
  });
}

void RawContainerReader::drop_unwritten() {
  while (!frames_.empty() && !has_good_pixels(frames_.back())) frames_.pop_back();
}

std::vector<std::uint8_t> RawContainerReader::pixels(const Place& place) const {
  std::vector<std::uint8_t> bytes(place.header.pixel_bytes);
  if (!read(bytes.data(), bytes.size(), place.offset + sizeof place.header)) bytes.clear();
  return bytes;
}

bool RawContainerReader::has_good_pixels(const Place& place) const {
  return fast_crc32(pixels(place)) == place.header.pixel_crc;
}

std::string RawContainerReader::place_text(std::size_t frame) const {
  return path_ + format_text(": frame %zu at byte %llu", frame, printable(frames_[frame].offset));
}

Image RawContainerReader::image(std::size_t frame) const {
  const Place& place = frames_[frame];
  Image image{place.header.width_px, place.header.height_px, place.header.format == hal::PixelFormat::mono16 ? 2U : 1U,
              pixels(place)};
  if (image.bytes.size() != place.header.pixel_bytes || fast_crc32(image.bytes) != place.header.pixel_crc)
    throw InputError(place_text(frame), 0, "the checksum of its pixels is wrong", "an undamaged frame");
  return image;
}

}  // namespace relnav::hil
