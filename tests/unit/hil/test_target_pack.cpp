// What `relnav pack` writes for a target without files.
#include "hil/replay/target_pack.hpp"

#include "tests/support/yaml_tables.hpp"  // before CppUTest redefines operators

#include <algorithm>
#include <cstring>
#include <sstream>

#include "fsw/app/config_image.hpp"
#include "hil/io/image.hpp"
#include "hil/io/raw_container.hpp"
#include "platform/files/flight_config_file.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::message_of;
using relnav::test::Scratch;

namespace {

std::string bytes_of(const std::string& path) {
  std::stringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

template <typename Object>
Object object_at(const std::string& bytes, std::size_t offset) {
  Object object;
  CHECK(offset + sizeof object <= bytes.size());
  std::memcpy(&object, bytes.data() + offset, sizeof object);
  return object;
}

/// The words that an InputError lists after "one of".
std::vector<std::string> names_in(const std::string& message) {
  const std::string lead = "(expected one of ";
  const std::size_t begin = message.find(lead) + lead.size();
  std::stringstream list(message.substr(begin, message.rfind(')') - begin));
  std::vector<std::string> names;
  for (std::string name; list >> name;) names.push_back(name.substr(0, name.find(',')));
  return names;
}

}  // namespace

TEST_GROUP(TargetPack) {
  Scratch scratch;

  std::string image_of(const app::FlightLoopConfig& config) {
    pack_config(config, scratch.path("setup.bin"));
    return bytes_of(scratch.path("setup.bin"));
  }
  /// Of the defaults with `text` read on top; what the reader says otherwise.
  std::string image_with(const std::string& text, std::string& problem) {
    app::FlightLoopConfig config = app::FlightLoopConfig::defaults(MotionKind::rigid_target);
    problem = message_of([&] { read_flight_config(scratch.write("c.yaml", text), config); });
    return problem.empty() ? image_of(config) : std::string();
  }
};

TEST(TargetPack, EveryValueOfTheConfigurationFileIsInTheImage) {
  std::string problem;
  const std::string defaults = image_with("", problem);
  static_cast<void>(image_with("none: {}\n", problem));
  std::size_t keys = 0;
  for (const std::string& section : names_in(problem)) {
    static_cast<void>(image_with(section + ": {none: 0}\n", problem));
    for (const std::string& key : names_in(problem)) {
      ++keys;
      const std::vector<std::string> values{"17",  "12",    "0.77", "1.25",      "2000", "300",
                                            "200", "false", "true", "rodrigues", "raise"};
      const bool seen = std::any_of(values.begin(), values.end(), [&](const std::string& value) {
        const std::string image = image_with(section + ": {" + key + ": " + value + "}\n", problem);
        return problem.empty() && image != defaults;
      });
      CHECK_TEXT(seen, (section + "." + key + " does not reach the target").c_str());
    }
  }
  CHECK(keys > 60);
}

TEST(TargetPack, FramesComeWithStampsAndChecksums) {
  std::vector<ImageEntry> entries;
  for (std::uint8_t i = 0; i < 3; ++i) {
    const auto png = encode_png({4, 2, 1, {i, 1, 2, 3, 4, 5, 6, 7}});
    entries.push_back(
        {Time{100 + i}, scratch.write(std::to_string(i) + ".png", std::string(png.begin(), png.end())), 1});
  }
  CameraIntrinsics camera;
  camera.width_px = 4;
  camera.height_px = 2;
  pack_frames(entries, camera, Depth::as_filed, scratch.path("f.rnc"));
  std::string file = bytes_of(scratch.path("f.rnc"));
  const auto header = object_at<hal::raw::FileHeader>(file, 0);
  CHECK(is_whole(header));
  LONGS_EQUAL(3, header.frames);
  for (std::uint32_t i = 0; i < 3; ++i) {
    const auto offset =
        static_cast<std::size_t>(object_at<std::uint64_t>(file, static_cast<std::size_t>(header.index_offset) + 8 * i));
    auto frame = object_at<hal::raw::FrameHeader>(file, offset);
    CHECK(is_whole(frame));
    LONGS_EQUAL(i, frame.sequence);
    LONGS_EQUAL(100 + i, frame.mid_exposure_ns);
    const std::array<std::uint8_t, 8> pixels{static_cast<std::uint8_t>(i), 1, 2, 3, 4, 5, 6, 7};
    MEMCMP_EQUAL(pixels.data(), file.data() + offset + sizeof frame, pixels.size());
    LONGS_EQUAL(crc32(pixels), frame.pixel_crc);
    frame.width_px = 5;
    CHECK(!is_whole(frame));  // the checksum
    frame.crc = crc_of(frame);
    CHECK(!is_whole(frame));  // the size
  }
}

TEST(TargetPack, RowsOfADriverAreWrittenWithoutTheirGaps) {
  const std::array<std::uint8_t, 8> memory{1, 2, 3, 99, 4, 5, 6, 99};
  hal::Frame frame;
  frame.pixels = memory.data();
  frame.width_px = 3;
  frame.height_px = 2;
  frame.stride_bytes = 4;
  RawContainerWriter writer(scratch.path("f.rnc"));
  writer.add(frame);
  writer.finish();
  const std::string file = bytes_of(scratch.path("f.rnc"));
  const std::array<std::uint8_t, 6> pixels{1, 2, 3, 4, 5, 6};
  MEMCMP_EQUAL(pixels.data(), file.data() + sizeof(hal::raw::FileHeader) + sizeof(hal::raw::FrameHeader),
               pixels.size());
  LONGS_EQUAL(crc32(pixels), object_at<hal::raw::FrameHeader>(file, sizeof(hal::raw::FileHeader)).pixel_crc);
}

TEST(TargetPack, AnImageThatCannotBeReadIsNamed) {
  CameraIntrinsics camera;
  camera.width_px = 4;
  camera.height_px = 2;
  const std::vector<ImageEntry> entries{{Time{1}, scratch.path("absent.png"), 1}};
  CHECK_MESSAGE_HOLDS(message_of([&] { pack_frames(entries, camera, Depth::as_filed, scratch.path("f.rnc")); }),
                      "absent.png");
  CHECK_MESSAGE_HOLDS(message_of([&] { pack_config({}, scratch.path("no/such/folder.bin")); }), "folder.bin");
}
