#include "hil/io/raw_container.hpp"

#include "platform/files/input_error.hpp"

namespace relnav::hil {

RawContainerWriter::RawContainerWriter(const std::string& path) : path_(path), file_(path, std::ios::binary) {
  const std::array<char, sizeof(hal::raw::FileHeader)> room{};
  write(room.data(), room.size());
}

void RawContainerWriter::write(const void* bytes, std::size_t size) {
  file_.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(size));
  if (!file_) throw InputError(path_, 0, "cannot be written", "room and permission to write");
}

void RawContainerWriter::add(const hal::Frame& frame, double gain) {
  const std::size_t row_bytes = std::size_t{frame.width_px} * (frame.format == hal::PixelFormat::mono16 ? 2 : 1);
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
  for (std::uint32_t v = 0; v < frame.height_px; ++v) {
    header.pixel_crc = crc32({frame.pixels + std::size_t{v} * frame.stride_bytes, row_bytes}, header.pixel_crc);
  }
  header.crc = crc_of(header);
  offsets_.push_back(static_cast<std::uint64_t>(file_.tellp()));
  write(&header, sizeof header);
  for (std::uint32_t v = 0; v < frame.height_px; ++v) {
    write(frame.pixels + std::size_t{v} * frame.stride_bytes, row_bytes);
  }
}

void RawContainerWriter::finish() {
  hal::raw::FileHeader header;
  header.frames = static_cast<std::uint32_t>(offsets_.size());
  header.index_offset = static_cast<std::uint64_t>(file_.tellp());
  header.crc = crc_of(header);
  write(offsets_.data(), offsets_.size() * sizeof offsets_.front());
  file_.seekp(0);
  write(&header, sizeof header);
  file_.flush();
  if (!file_) throw InputError(path_, 0, "cannot be written", "room and permission to write");
}

}  // namespace relnav::hil
