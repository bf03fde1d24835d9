// Raw containers that were cut off, damaged, or made to deceive.
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <sstream>

#include "hil/io/fast_crc32.hpp"
#include "hil/io/raw_container.hpp"
#include "hil/io/raw_container_reader.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::message_of;
using relnav::test::Scratch;

namespace {

constexpr std::size_t file_header_bytes = sizeof(hal::raw::FileHeader);
constexpr std::size_t frame_header_bytes = sizeof(hal::raw::FrameHeader);
constexpr std::uint32_t frames_written = 3;
constexpr std::size_t pixel_bytes = 8;
constexpr std::size_t frame_bytes = frame_header_bytes + pixel_bytes;

std::string content_of(const std::string& path) {
  std::stringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

std::vector<std::uint8_t> pixels_of(std::uint32_t k) {
  std::vector<std::uint8_t> pixels(pixel_bytes);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(17 * k + i);
  return pixels;
}

hal::Frame frame_over(const std::vector<std::uint8_t>& pixels, std::uint32_t k) {
  hal::Frame frame;
  frame.pixels = pixels.data();
  frame.width_px = 4;
  frame.height_px = 2;
  frame.stride_bytes = 4;
  frame.sequence = k;
  frame.mid_exposure = {1000 + k};
  frame.first_data = {2000 + k};
  frame.dequeued = {3000 + k};
  frame.exposure = {500};
  return frame;
}

template <typename Header>
std::string with_crc(Header header) {
  header.crc = crc_of(header);
  std::string bytes(sizeof header, '\0');
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

/// No file of this process gets larger, while this exists.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(std::size_t bytes) : former_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &former_);
    rlimit limit = former_;
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &former_);
    std::signal(SIGXFSZ, former_handler_);
  }

 private:
  rlimit former_{};
  void (*former_handler_)(int);
};

}  // namespace

TEST_GROUP(RawContainer) {
  Scratch scratch;

  /// A file with three frames, as a whole or as a loss of power leaves it.
  std::string recording(bool finished) {
    RawContainerWriter writer(scratch.path("whole.rnc"));
    for (std::uint32_t k = 0; k < frames_written; ++k) {
      const auto pixels = pixels_of(k);
      writer.add(frame_over(pixels, k), 1.5 + k);
    }
    if (finished) writer.finish();
    return content_of(scratch.path("whole.rnc"));
  }
  RawContainerReader reader_of(const std::string& content) {
    return RawContainerReader(scratch.write("x.rnc", content));
  }
  static bool is_right(const RawContainerReader& reader, std::size_t at) {
    const std::uint32_t k = reader.frames()[at].header.sequence;
    return k < frames_written && reader.image(at).bytes == pixels_of(k);
  }
  static bool has_note(const RawContainerReader& reader, const std::string& piece) {
    return std::any_of(reader.notes().begin(), reader.notes().end(),
                       [&](const std::string& note) { return note.find(piece) != std::string::npos; });
  }
};

TEST(RawContainer, TheFastChecksumIsTheOtherOne) {
  std::vector<std::uint8_t> bytes(1000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * i >> 3U);
  for (const std::size_t size : {0U, 1U, 7U, 64U, 1000U}) {
    const std::span part = std::span(bytes).first(size);
    CHECK_EQUAL(crc32(part), fast_crc32(part));
    CHECK_EQUAL(crc32(part, 12345U), fast_crc32(part, 12345U));
  }
}

TEST(RawContainer, WhatWasWrittenIsRead) {
  const RawContainerReader reader = reader_of(recording(true));
  CHECK_EQUAL(frames_written, reader.frames().size());
  CHECK_FALSE(reader.is_cut());
  CHECK(reader.notes().empty());
  for (std::uint32_t k = 0; k < frames_written; ++k) {
    const hal::raw::FrameHeader& header = reader.frames()[k].header;
    CHECK_EQUAL(k, header.sequence);
    CHECK_EQUAL(1000 + k, header.mid_exposure_ns);
    CHECK_EQUAL(2000 + k, header.first_data_ns);
    CHECK_EQUAL(3000 + k, header.dequeued_ns);
    CHECK_EQUAL(500, header.exposure_ns);
    CHECK_EQUAL(1.5 + k, header.gain);
    CHECK(is_right(reader, k));
  }
}

TEST(RawContainer, ARecordingCutOffAnywhereKeepsItsWholeFrames) {
  const std::string whole = recording(false);
  CHECK_EQUAL(file_header_bytes + frames_written * frame_bytes, whole.size());
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    const RawContainerReader reader = reader_of(whole.substr(0, size));
    const std::size_t expected = size < file_header_bytes ? 0 : (size - file_header_bytes) / frame_bytes;
    CHECK_EQUAL(expected, reader.frames().size());
    CHECK(reader.is_cut());
    CHECK(has_note(reader, "cut off: " + std::to_string(expected) + " whole frames"));
    for (std::size_t k = 0; k < expected; ++k) CHECK(is_right(reader, k));
  }
}

TEST(RawContainer, AFinishedFileThatLostItsEndKeepsItsWholeFrames) {
  const std::string whole = recording(true);
  const std::size_t index = file_header_bytes + frames_written * frame_bytes;
  for (std::size_t size = file_header_bytes; size < whole.size(); ++size) {
    const RawContainerReader reader = reader_of(whole.substr(0, size));
    CHECK_EQUAL(std::min(size - file_header_bytes, index - file_header_bytes) / frame_bytes, reader.frames().size());
    CHECK_EQUAL(size < index, reader.is_cut());
    CHECK_FALSE(reader.notes().empty());
    for (std::size_t k = 0; k < reader.frames().size(); ++k) CHECK(is_right(reader, k));
  }
}

TEST(RawContainer, PixelsThatNeverReachedTheDiskAreCutOffToo) {
  std::string content = recording(false);
  std::fill(content.end() - pixel_bytes, content.end(), '\0');
  const RawContainerReader reader = reader_of(content);
  CHECK_EQUAL(2, reader.frames().size());
  CHECK(has_note(reader, "2 whole frames, 80 bytes after them"));
}

TEST(RawContainer, NoFlippedBitMakesAWrongFrame) {
  for (const bool finished : {true, false}) {
    const std::string whole = recording(finished);
    for (std::size_t bit = 0; bit < 8 * whole.size(); bit += 5) {  // of each byte one or two
      std::string content = whole;
      content[bit / 8] = static_cast<char>(content[bit / 8] ^ (1 << (bit % 8)));
      const RawContainerReader reader = reader_of(content);
      std::size_t good = 0;
      for (std::size_t at = 0; at < reader.frames().size(); ++at) {
        if (!reader.has_good_pixels(at)) {
          CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(reader.image(at)); }),
                              "x.rnc: frame " + std::to_string(at) + " at byte ");
          continue;
        }
        CHECK(is_right(reader, at));
        ++good;
      }
      const std::size_t place = bit / 8;
      const bool in_frames = place >= file_header_bytes && place < file_header_bytes + frames_written * frame_bytes;
      CHECK_EQUAL_TEXT(in_frames ? frames_written - 1 : frames_written, good, std::to_string(bit).c_str());
      if (good == reader.frames().size()) CHECK_FALSE(reader.notes().empty());  // or image() has named it
    }
  }
}

TEST(RawContainer, NoSizeIsBelievedBeyondTheFile) {
  hal::raw::FileHeader file;
  file.frames = 0xFFFFFFFF;
  file.index_offset = file_header_bytes;
  hal::raw::FrameHeader frame;
  frame.width_px = frame.height_px = 16384;
  frame.pixel_bytes = 16384 * 16384;
  CHECK_EQUAL(0, reader_of(with_crc(file)).frames().size());
  const std::string nothing(file_header_bytes, '\0');
  CHECK_EQUAL(0, reader_of(nothing + with_crc(frame)).frames().size());
  file.frames = 1;
  file.index_offset = file_header_bytes + frame_header_bytes;
  const std::uint64_t place = file_header_bytes;
  const std::string index(reinterpret_cast<const char*>(&place), sizeof place);
  file.index_crc = crc32({reinterpret_cast<const std::uint8_t*>(index.data()), index.size()});
  const RawContainerReader indexed = reader_of(with_crc(file) + with_crc(frame) + index);
  CHECK_EQUAL(0, indexed.frames().size());
  CHECK(has_note(indexed, "(1 of 1) has a damaged header"));
  file.index_offset = ~std::uint64_t{0};
  CHECK(reader_of(with_crc(file) + std::string(100, 'x')).is_cut());
}

TEST(RawContainer, OtherFilesAreRefusedByName) {
  CHECK_MESSAGE_HOLDS(message_of([&] { RawContainerReader reader(scratch.path("absent.rnc")); }), "absent.rnc");
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(reader_of("\x89PNG\r\n or something")); }), "no file header");
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(reader_of(std::string(100, 'x'))); }), "no file header");
  CHECK_MESSAGE_HOLDS(message_of([&] { RawContainerReader reader("/dev/null"); }), "/dev/null");
}

TEST(RawContainer, AFullDiskCostsNothingThatIsThere) {
  for (const std::size_t room :
       {std::size_t{0}, std::size_t{50}, frame_bytes - 1, std::size_t{frame_header_bytes + 3}}) {
    const FileSizeLimit limit(file_header_bytes + 2 * frame_bytes + room);
    RawContainerWriter writer(scratch.path("full.rnc"));
    for (std::uint32_t k = 0; k < 2; ++k) {
      const auto pixels = pixels_of(k);
      writer.add(frame_over(pixels, k));
    }
    const auto pixels = pixels_of(2);
    CHECK_MESSAGE_HOLDS(message_of([&] { writer.add(frame_over(pixels, 2)); }), "full.rnc: cannot be written");
    const bool finished = message_of([&] { writer.finish(); }).empty();
    CHECK_EQUAL(room >= 2 * sizeof(std::uint64_t), finished);
    const RawContainerReader reader(scratch.path("full.rnc"));
    CHECK_EQUAL(2, reader.frames().size());
    CHECK_EQUAL(finished, !reader.is_cut());
    CHECK(is_right(reader, 0) && is_right(reader, 1));
  }
  CHECK_MESSAGE_HOLDS(message_of([&] { RawContainerWriter writer(scratch.path("no/folder.rnc")); }), "no/folder.rnc");
}
