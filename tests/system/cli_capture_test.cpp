/// relnav capture, export, and data sets of raw containers as a user meets them. With a camera: tests/hil/capture.
#include <filesystem>
#include <fstream>
#include <iterator>

#include "hil/io/image.hpp"
#include "hil/io/raw_container.hpp"
#include "hil/io/raw_container_reader.hpp"
#include "tests/support/scratch.hpp"
#include "tests/system/tool_run.hpp"

using relnav::test::Scratch;
using relnav::test::ToolRun;

namespace {

namespace fs = std::filesystem;

const std::string captures = std::string(RELNAV_SOURCE_DIR) + "/hil/captures/";

std::string content_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

TEST_GROUP(CliCapture) {
  Scratch scratch;
  ToolRun tool(const std::string& arguments) { return relnav::test::relnav_tool(scratch, arguments); }
  void check_done(const std::string& arguments) {
    const ToolRun run = tool(arguments);
    CHECK_EQUAL_TEXT(0, run.exit_status, (arguments + "\n" + run.err).c_str());
  }
  void check_unusable(const std::string& arguments, const std::string& piece) {
    const ToolRun run = tool(arguments);
    CHECK_EQUAL_TEXT(2, run.exit_status, (arguments + "\n" + run.err).c_str());
    CHECK_MESSAGE_HOLDS(run.err.substr(0, run.err.find_last_not_of('\n') + 1), piece);
  }
  /// A folder of containers cam0.rnc, ... with all that belongs to them, as `relnav pack` makes the containers.
  std::string packed(const std::string& name, const std::string& mode, int cameras) {
    const std::string folder = scratch.path("packed");
    check_done("pack --dataset " + captures + name + " --mode " + mode + " --out " + folder);
    for (int k = 0; k < cameras; ++k) {
      const std::string number = std::to_string(k);
      fs::rename(folder + "/frames" + number + ".rnc", folder + "/cam" + number + ".rnc");
      fs::copy_file(captures + name + "/mav0/cam" + number + "/sensor.yaml", folder + "/cam" + number + ".yaml");
    }
    fs::copy_file(captures + name + "/target.yaml", folder + "/target.yaml");
    fs::copy_file(captures + name + "/truth.tum", folder + "/truth.tum");
    return folder;
  }
  std::string telemetry_of(const std::string& dataset, const std::string& mode, const std::string& out) {
    check_done("replay --dataset " + dataset + " --mode " + mode + " --out " + scratch.path(out));
    return content_of(scratch.path(out + "/telemetry.bin"));
  }
  /// Three 16-bit frames of 4 x 2 pixels, two of one stamp.
  std::string deep_container() {
    const std::string path = scratch.path("deep.rnc");
    relnav::hil::RawContainerWriter writer(path);
    for (std::uint32_t k = 0; k < 3; ++k) {
      std::vector<std::uint16_t> pixels(8, static_cast<std::uint16_t>(0x1234 + k));
      relnav::hal::Frame frame;
      frame.pixels = reinterpret_cast<const std::uint8_t*>(pixels.data());
      frame.width_px = 4;
      frame.height_px = 2;
      frame.stride_bytes = 8;
      frame.format = relnav::hal::PixelFormat::mono16;
      frame.sequence = 10 + k;
      frame.mid_exposure = {1000 + (k == 2 ? 1 : 0)};
      frame.exposure = {77};
      writer.add(frame, 2.5);
    }
    writer.finish();
    return path;
  }
};

TEST(CliCapture, ContainersReplayToTheSameBytesAsTheirImages) {
  const std::string folder = packed("lights_mono", "coop-mono", 1);
  const std::string expected = telemetry_of(captures + "lights_mono", "coop-mono", "a");
  CHECK(expected.size() > 1000);
  CHECK(expected == telemetry_of(folder, "coop-mono", "b"));
  CHECK(expected == telemetry_of(folder + "/cam0.rnc", "coop-mono", "c"));
  check_done("export " + folder + "/cam0.rnc --out " + scratch.path("seq"));
  fs::copy_file(folder + "/target.yaml", scratch.path("seq/target.yaml"));
  CHECK(expected == telemetry_of(scratch.path("seq"), "coop-mono", "d"));
  CHECK(content_of(scratch.path("b/report.html")).size() > 10000);
}

TEST(CliCapture, TwoContainersAreAStereoDataSet) {
  const std::string folder = packed("lights_stereo", "coop-stereo", 2);
  CHECK(telemetry_of(captures + "lights_stereo", "coop-stereo", "a") == telemetry_of(folder, "coop-stereo", "b"));
  check_unusable("replay --dataset " + folder + "/cam0.rnc --mode coop-stereo --out " + scratch.path("c"),
                 "cam0.rnc: holds one camera");
}

TEST(CliCapture, ADamagedFrameIsLeftOutAndNamed) {
  const std::string folder = packed("lights_mono", "coop-mono", 1);
  {
    std::fstream file(folder + "/cam0.rnc", std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(32 + 72 + 1000);
    file.put('x');
  }
  const ToolRun run = tool("export " + folder + "/cam0.rnc --out " + scratch.path("seq"));
  CHECK_EQUAL(0, run.exit_status);
  CHECK(run.out.find("19 of 20 frames") != std::string::npos);
  CHECK(run.err.find("cam0.rnc: frame 0 at byte 32: the checksum") != std::string::npos);
  fs::resize_file(folder + "/cam0.rnc", fs::file_size(folder + "/cam0.rnc") - 1'000'000);
  const ToolRun cut = tool("replay --dataset " + folder + " --mode coop-mono --out " + scratch.path("out"));
  CHECK_EQUAL_TEXT(0, cut.exit_status, cut.err.c_str());
  CHECK(cut.err.find("frame 0 at byte 32 has damaged pixels and is left out") != std::string::npos);
  CHECK(cut.err.find("cut off: 1") != std::string::npos);
}

TEST(CliCapture, ExportWritesEveryBitAndWhatTheDriverSaid) {
  const ToolRun run = tool("export " + deep_container() + " --out " + scratch.path("seq"));
  CHECK_EQUAL_TEXT(0, run.exit_status, run.err.c_str());
  CHECK(run.out.find("3 of 3 frames") != std::string::npos);
  CHECK(run.out.find("no sensor.yaml") != std::string::npos);
  const std::string folder = scratch.path("seq/mav0/cam0");
  STRCMP_EQUAL("#timestamp [ns],filename\n1000,1000.png\n1000,1000_2.png\n1001,1001.png\n",
               content_of(folder + "/data.csv").c_str());
  CHECK(content_of(folder + "/frames.csv").find("\n1001,12,77,2.5,0,0,monotonic,0\n") != std::string::npos);
  const relnav::hil::Image image = relnav::hil::read_png(folder + "/data/1000_2.png");
  CHECK_EQUAL(2, image.bytes_per_pixel);
  CHECK_EQUAL(0x35, static_cast<int>(image.bytes[0]));
  CHECK_EQUAL(0x12, static_cast<int>(image.bytes[1]));
}

TEST(CliCapture, ExportRefusesWhatIsNotItsOwn) {
  const std::string container = deep_container();
  const std::string out = " --out " + scratch.path("seq");
  check_unusable("export " + scratch.path("absent.rnc") + out, "absent.rnc: cannot be opened");
  check_unusable("export " + scratch.write("x.rnc", "hello") + out, "no file header");
  scratch.write("deep.yaml",
                "camera_model: pinhole\nintrinsics: [60, 60, 31.5, 23.5]\nresolution: [64, 48]\n"
                "distortion_model: none\ndistortion_coefficients: []\n");
  check_unusable("export " + container + out, "deep.yaml: is for 64 x 48 pixels");
  CHECK_FALSE(fs::exists(scratch.path("seq")));
  fs::remove(scratch.path("deep.yaml"));
  scratch.write("seq/mine.txt", "mine");
  check_unusable("export " + container + out, "seq: is not empty");
  check_done("export " + container + out + " --force");
  check_unusable("export " + container + out, "cam0: is not empty");
  check_done("export " + container + out + " --camera 1");  // a second camera joins
  scratch.write("seq/mav0/cam0/data/old.png", "old");
  check_done("export " + container + out + " --force");
  CHECK_FALSE(fs::exists(scratch.path("seq/mav0/cam0/data/old.png")));
  CHECK(fs::exists(scratch.path("seq/mine.txt")));
}

TEST(CliCapture, CaptureRefusesWithOneLineAndLeavesFilesAlone) {
  const std::string out = " --out " + scratch.path("c.rnc");
  const std::string size = " --width 640 --height 480";
  check_unusable("capture --camera usb:0" + size + out, "names no camera");
  check_unusable("capture --camera v4l2:" + size + out, "names no camera");
  check_unusable("capture --camera v4l2:/dev/null" + out, "does not know the size");
  check_unusable("capture --camera v4l2:/dev/null --format rgb" + size + out, "is no pixel format");
  check_unusable("capture --camera v4l2:/dev/null --serial 7" + size + out, "these with aravis: only");
  check_unusable("capture --camera v4l2:/dev/null --trigger software" + size + out, "no software trigger");
  check_unusable("capture --camera v4l2:/dev/null --frames 0" + size + out, "--frames");
  check_unusable("capture --camera v4l2:/dev/null --width 10 --calibration " + captures +
                     "lights_mono/mav0/cam0/sensor.yaml" + out,
                 "is for 640 x 480 pixels");
  check_unusable("capture --camera v4l2:/dev/null" + size + out, "/dev/null");
  check_unusable("capture --camera v4l2:" + scratch.path("none") + size + out, "none");
  CHECK_FALSE(fs::exists(scratch.path("c.rnc")));
  scratch.write("c.rnc", "precious");
  check_unusable("capture --camera v4l2:/dev/null" + size + out, "c.rnc: exists");
  check_unusable("capture --camera v4l2:/dev/null --force" + size + out, "/dev/null");
  STRCMP_EQUAL("precious", content_of(scratch.path("c.rnc")).c_str());
}
