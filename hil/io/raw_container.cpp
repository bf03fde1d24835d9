#include "hil/io/raw_container.hpp"

#include <fcntl.h>
#include <sys/uio.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "hil/io/fast_crc32.hpp"
#include "platform/files/input_error.hpp"

namespace relnav::hil {
namespace {

iovec piece_of(const void* bytes, std::size_t size) { return {const_cast<void*>(bytes), size}; }

/// A new file is there after a loss of power only once its folder is on the disk, too.
void sync_folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const FileHandle handle(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (handle.is_open()) static_cast<void>(::fsync(handle.get()));  // some file systems cannot
}

}  // namespace

RawContainerWriter::RawContainerWriter(const std::string& path)
    : path_(path), file_(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
  const std::array<char, sizeof(hal::raw::FileHeader)> room{};
  if (!file_.is_open() || !write({piece_of(room.data(), room.size())}, 0)) fail();
  sync_folder_of(path);
}

void RawContainerWriter::fail() {
  throw InputError(path_, 0, std::string("cannot be written: ") + std::strerror(errno), "room and permission to write");
}

void RawContainerWriter::take_back() {
  const int problem = errno;
  static_cast<void>(::ftruncate(file_.get(), static_cast<off_t>(end_)));  // a reader finds the end without it, too
  errno = problem;
  fail();
}

bool RawContainerWriter::write(std::vector<iovec> pieces, std::uint64_t offset) {
  std::size_t first = 0;
  while (first < pieces.size()) {
    const ssize_t written =
        ::pwritev(file_.get(), &pieces[first], static_cast<int>(pieces.size() - first), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    offset += static_cast<std::uint64_t>(written);
    auto left = static_cast<std::size_t>(written);
    while (first < pieces.size() && left >= pieces[first].iov_len) left -= pieces[first++].iov_len;
    if (left > 0) {
      pieces[first].iov_base = static_cast<std::uint8_t*>(pieces[first].iov_base) + left;
      pieces[first].iov_len -= left;
    }
  }
  return true;
}

void RawContainerWriter::add(const hal::Frame& frame, double gain) {
  const std::size_t row_bytes = std::size_t{frame.width_px} * (frame.format == hal::PixelFormat::mono16 ? 2 : 1);
  const std::uint8_t* pixels = frame.pixels;
  if (frame.stride_bytes != row_bytes) {
    rows_.resize(row_bytes * frame.height_px);
    for (std::uint32_t v = 0; v < frame.height_px; ++v)
      std::copy_n(frame.pixels + std::size_t{v} * frame.stride_bytes, row_bytes, &rows_[v * row_bytes]);
    pixels = rows_.data();
  }
  hal::raw::FrameHeader header;
  header.sequence = frame.sequence;
  header.mid_exposure_ns = frame.mid_exposure.ns;
  header.first_data_ns = frame.first_data.ns;
  header.dequeued_ns = frame.dequeued.ns;
  header.exposure_ns = frame.exposure.ns;
  header.gain = gain;
  header.width_px = frame.width_px;
  header.height_px = frame.height_px;
  header.format = frame.format;
  header.clock = frame.clock;
  header.pixel_bytes = static_cast<std::uint32_t>(row_bytes * frame.height_px);
  header.pixel_crc = fast_crc32({pixels, header.pixel_bytes});
  header.crc = crc_of(header);
  if (!write({piece_of(&header, sizeof header), piece_of(pixels, header.pixel_bytes)}, end_)) take_back();
  offsets_.push_back(end_);
  end_ += sizeof header + header.pixel_bytes;
}

void RawContainerWriter::sync() {
  if (::fdatasync(file_.get()) != 0) fail();
}

void RawContainerWriter::finish() {
  const std::size_t index_bytes = offsets_.size() * sizeof(std::uint64_t);
  hal::raw::FileHeader header;
  header.frames = static_cast<std::uint32_t>(offsets_.size());
  header.index_offset = end_;
  header.index_crc = fast_crc32({reinterpret_cast<const std::uint8_t*>(offsets_.data()), index_bytes});
  header.crc = crc_of(header);
  if (index_bytes > 0 && !write({piece_of(offsets_.data(), index_bytes)}, end_)) take_back();
  sync();  // the header comes after all that it points to
  if (!write({piece_of(&header, sizeof header)}, 0)) fail();
  sync();
}

}  // namespace relnav::hil
