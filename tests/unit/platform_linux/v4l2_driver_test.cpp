// V4l2Driver against a device played at its system calls: negotiation, controls, buffers, stamps, faults, leaks.
#include "platform/linux/v4l2_driver.hpp"

#include <linux/videodev2.h>
#include <poll.h>

#include <cerrno>
#include <cstdint>
#include <string>
#include <vector>

#include "platform/linux/stream_camera.hpp"
#include "tests/support/allocation_trap.hpp"
#include "tests/support/scripted_video.hpp"

#include <CppUTest/TestHarness.h>

using namespace relnav;
using namespace relnav::platform::linux;
using test::ScriptedVideo;

namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr Duration wait{5 * ms};

}  // namespace

TEST_GROUP(V4l2Driver) {
  platform::host::ScriptedClock clock{Time{1'000'000'000}};
  ScriptedVideo device{clock};
  CameraSettings settings;
  V4l2Driver driver{device, clock};
  RawImage image;

  void setup() override {
    settings.device = "/dev/video0";
    settings.width_px = 8;
    settings.height_px = 4;
  }
  void teardown() override {
    driver.close();
    check_nothing_left();
  }
  void check_nothing_left() const {
    LONGS_EQUAL(0, device.mistakes);
    LONGS_EQUAL(0, device.files());
    LONGS_EQUAL(0, device.mappings());
    CHECK_FALSE(device.streaming());
  }
  void open() {
    const Status status = driver.open(settings);
    STRCMP_EQUAL("", driver.problem().c_str());
    CHECK_TRUE(status == Status::ok);
  }
  /// open() fails, says so and leaves nothing behind.
  void check_refused(Status expected, const char* problem) {
    const Status status = driver.open(settings);
    STRCMP_EQUAL(problem, driver.problem().c_str());
    STRCMP_EQUAL(to_string(expected), to_string(status));
    check_nothing_left();
  }
  const RawImage& take_sent() {
    device.send();
    CHECK_TRUE(driver.take(wait, image) == Status::ok);
    return image;
  }
  const RawImage& pass_sent() {
    take_sent();
    CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
    return image;
  }
  void check_lost(const char* problem) {
    const Status status = driver.take(wait, image);
    STRCMP_EQUAL(problem, driver.problem().c_str());
    CHECK_TRUE(status == Status::device_lost);
  }
};

// Opening

TEST(V4l2Driver, StreamsWhatTheCameraSends) {
  device.padding = 3;
  open();
  LONGS_EQUAL(V4L2_PIX_FMT_GREY, device.format().fmt.pix.pixelformat);
  LONGS_EQUAL(8, device.queued());
  LONGS_EQUAL(6, driver.max_loans());
  take_sent();
  CHECK_TRUE(image.complete);
  CHECK_TRUE(image.format == RawFormat::grey8);
  LONGS_EQUAL(8, image.width_px);
  LONGS_EQUAL(4, image.height_px);
  LONGS_EQUAL(11, image.stride_bytes);
  LONGS_EQUAL(44, image.bytes.size());
  LONGS_EQUAL(1, image.bytes[0]);
  LONGS_EQUAL(7, device.queued());
  CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
  LONGS_EQUAL(8, device.queued());
}

TEST(V4l2Driver, WorksOutTheStrideThatADeviceDoesNotTell) {
  device.tells_stride = false;
  settings.format = "yuyv";
  open();
  LONGS_EQUAL(16, take_sent().stride_bytes);
  CHECK_TRUE(image.format == RawFormat::yuyv);
}

TEST(V4l2Driver, TakesTheDeepestFormatUnlessOneIsNamed) {
  device.formats = {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_Y10, V4L2_PIX_FMT_Y12};
  open();
  CHECK_TRUE(take_sent().format == RawFormat::y12);
  settings.format = "y10";
  open();
  CHECK_TRUE(take_sent().format == RawFormat::y10);
  device.formats = {V4L2_PIX_FMT_SRGGB8};
  settings.format.clear();
  open();
  CHECK_TRUE(take_sent().format == RawFormat::bayer_rggb8);
}

TEST(V4l2Driver, WhatIsNoCameraIsRefused) {
  device.open_answer = -EISDIR;
  check_refused(Status::unsupported, "/dev/video0: Is a directory");
  device.open_answer = 0;
  device.answers[VIDIOC_QUERYCAP] = -ENOTTY;
  check_refused(Status::unsupported, "/dev/video0: not a V4L2 device");
  device.answers[VIDIOC_QUERYCAP] = -EINVAL;
  check_refused(Status::unsupported, "/dev/video0: not a V4L2 device");
  device.answers.clear();
  device.capabilities = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING;
  check_refused(Status::unsupported,
                "/dev/video0: is not a camera (a loopback device becomes one when somebody writes to it)");
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
  check_refused(Status::unsupported, "/dev/video0: captures in several planes, one was expected");
  device.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_READWRITE;
  check_refused(Status::unsupported, "/dev/video0: cannot stream, only be read");
}

TEST(V4l2Driver, ANodeThatCannotBeOpenedIsExplained) {
  device.present = false;
  check_refused(Status::no_data, "/dev/video0: does not exist");
  device.present = true;
  device.open_answer = -ENODEV;
  check_refused(Status::no_data, "/dev/video0: there is no device behind it");
  device.open_answer = -EACCES;
  check_refused(Status::io_error, "/dev/video0: no permission; the group of the device node (video) has it");
  device.open_answer = -EBUSY;
  check_refused(Status::no_capacity,
                "/dev/video0: busy: another program uses it (a loopback device: nobody writes to it yet)");
  device.open_answer = -EIO;
  check_refused(Status::io_error, "/dev/video0: Input/output error");
}

TEST(V4l2Driver, FormatsThatDoNotDoAreListed) {
  device.formats = {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_NV12};
  check_refused(Status::unsupported,
                "/dev/video0: offers MJPG, NV12; expected one of grey8, y10, y12, y16, yuyv, bayer_*");
  device.formats = {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUYV};
  settings.format = "grey8";
  check_refused(Status::unsupported, "/dev/video0: offers MJPG, yuyv; expected grey8");
  settings.format = "y12p";
  check_refused(Status::unsupported, "/dev/video0: V4L2 has no pixel format y12p");
  settings.format = "grey";
  check_refused(Status::invalid_argument, "/dev/video0: there is no pixel format \"grey\"");
  device.formats.clear();
  settings.format.clear();
  check_refused(Status::unsupported,
                "/dev/video0: offers no pixel format; expected one of grey8, y10, y12, y16, yuyv, bayer_*");
}

TEST(V4l2Driver, ASizeNotOfferedIsRefused) {
  device.formats = {V4L2_PIX_FMT_GREY};
  settings.width_px = 640;
  settings.height_px = 480;
  check_refused(Status::unsupported, "/dev/video0: gives 8 x 4 GREY, 640 x 480 grey8 was asked for");
  settings.height_px = 0;
  check_refused(Status::invalid_argument, "/dev/video0: the size of the images is needed");
  settings.height_px = 4;
  settings.width_px = 0;
  check_refused(Status::invalid_argument, "/dev/video0: the size of the images is needed");
}

TEST(V4l2Driver, HalfImagesAreRefused) {
  device.field = V4L2_FIELD_INTERLACED;
  check_refused(Status::unsupported, "/dev/video0: gives half-images, whole ones were asked for");
}

TEST(V4l2Driver, BusyAtAnyStepIsNoCapacity) {
  for (const unsigned long request : {VIDIOC_S_FMT, VIDIOC_REQBUFS, VIDIOC_STREAMON}) {
    device.answers = {{request, -EBUSY}};
    CHECK_TRUE(driver.open(settings) == Status::no_capacity);
    CHECK_TRUE(driver.problem().find("busy: another program uses it") != std::string::npos);
    check_nothing_left();
  }
  device.answers = {{VIDIOC_STREAMON, -ENOSPC}};
  check_refused(Status::no_capacity, "/dev/video0: the bus has no bandwidth left for it");
}

TEST(V4l2Driver, EveryStepThatFailsLeavesNothingBehind) {
  settings.rate_hz = 30.0;
  settings.exposure_us = 1000.0;
  settings.gain = 4.0;
  device.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {.value = 1, .least = 1, .most = 5000};
  device.controls[V4L2_CID_GAIN] = {.value = 0, .least = 0, .most = 255};
  for (const unsigned long request : {VIDIOC_QUERYCAP, VIDIOC_ENUM_FMT, VIDIOC_S_FMT, VIDIOC_G_PARM, VIDIOC_S_PARM,
                                      VIDIOC_S_CTRL, VIDIOC_REQBUFS, VIDIOC_QUERYBUF, VIDIOC_QBUF, VIDIOC_STREAMON}) {
    device.answers = {{request, -EIO}};
    CHECK_TRUE(driver.open(settings) == Status::io_error);
    CHECK_TRUE(driver.problem().find("Input/output error") != std::string::npos);
    check_nothing_left();
  }
  device.answers.clear();
  device.map_answer = -ENOMEM;
  check_refused(Status::no_capacity, "/dev/video0: mapping of buffer 1: Cannot allocate memory");
  device.map_answer = 0;
  open();
}

TEST(V4l2Driver, InterruptedCallsAreRepeated) {
  device.interrupts = true;
  open();
  take_sent();
  CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
  CHECK_TRUE(driver.take(wait, image) == Status::timeout);
}

TEST(V4l2Driver, ADeviceMayGiveFewerBuffers) {
  device.most_buffers = 3;
  open();
  LONGS_EQUAL(3, device.queued());
  LONGS_EQUAL(1, driver.max_loans());
  device.most_buffers = 2;
  open();
  LONGS_EQUAL(1, driver.max_loans());
  device.most_buffers = 1;
  check_refused(Status::no_capacity, "/dev/video0: gives 1 buffers, 2 are needed at least");
}

TEST(V4l2Driver, OpeningAgainClosesFirst) {
  open();
  take_sent();
  open();
  LONGS_EQUAL(1, device.files());
  LONGS_EQUAL(8, device.mappings());
  CHECK_TRUE(driver.give_back(0) == Status::stale_handle);
}

// Settings

TEST(V4l2Driver, RateIsSetOrRefused) {
  settings.rate_hz = 15.0;
  open();
  LONGS_EQUAL(15, device.rate_hz());
  settings.rate_hz = 200.0;
  check_refused(Status::unsupported, "/dev/video0: rate of 200 Hz: gives 30 Hz");
  device.rates_hz.clear();
  check_refused(Status::unsupported, "/dev/video0: rate of 200 Hz: its rate cannot be set");
  settings.rate_hz = 0.0;
  device.seen.clear();
  open();
  CHECK_FALSE(device.seen.count(VIDIOC_S_PARM) > 0);
}

TEST(V4l2Driver, ExposureIsSetInStepsOfTheControl) {
  device.controls[V4L2_CID_EXPOSURE_AUTO] = {.value = V4L2_EXPOSURE_APERTURE_PRIORITY, .least = 0, .most = 3};
  device.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {.value = 157, .least = 3, .most = 2047};
  open();
  CHECK_TRUE(take_sent().exposure.ns == 0);  // automatic: not known
  settings.exposure_us = 4960.0;
  open();
  LONGS_EQUAL(V4L2_EXPOSURE_MANUAL, device.controls[V4L2_CID_EXPOSURE_AUTO].value);
  LONGS_EQUAL(50, device.controls[V4L2_CID_EXPOSURE_ABSOLUTE].value);
  CHECK_TRUE(take_sent().exposure.ns == 5 * ms);
  settings.exposure_us = 0.0;
  open();
  CHECK_TRUE(take_sent().exposure.ns == 5 * ms);  // manual: as it stands
  settings.exposure_us = 100.0;
  check_refused(Status::unsupported, "/dev/video0: exposure of 1 x 100 us: takes 3 to 2047 x 100 us");
  settings.exposure_us = 40'000.0;
  settings.rate_hz = 30.0;
  check_refused(Status::invalid_argument, "/dev/video0: an exposure of 40000 us does not fit into a period at 30 Hz");
}

TEST(V4l2Driver, ExposureInLinesNeedsToKnowALine) {
  settings.exposure_us = 1000.0;
  check_refused(Status::unsupported,
                "/dev/video0: exposure of 1000 us: it has no control for that, or none of a known unit");
  device.controls[V4L2_CID_EXPOSURE] = {.value = 1, .least = 1, .most = 1000};
  check_refused(Status::unsupported,
                "/dev/video0: exposure of 1000 us: it has no control for that, or none of a known unit");
  device.controls[V4L2_CID_HBLANK] = {.value = 92, .least = 92, .most = 92};
  device.pixel_rate_hz = 10'000'000;  // 100 pixels a line: 10 us
  open();
  LONGS_EQUAL(100, device.controls[V4L2_CID_EXPOSURE].value);
  CHECK_TRUE(take_sent().exposure.ns == ms);
}

TEST(V4l2Driver, GainIsSetWithoutItsAutomatism) {
  settings.gain = 12.4;
  check_refused(Status::unsupported, "/dev/video0: gain of 12: it has no such control");
  device.controls[V4L2_CID_ANALOGUE_GAIN] = {.value = 3, .least = 0, .most = 16};
  open();
  LONGS_EQUAL(12, device.controls[V4L2_CID_ANALOGUE_GAIN].value);
  device.controls[V4L2_CID_AUTOGAIN] = {.value = 1, .least = 0, .most = 1};
  device.controls[V4L2_CID_GAIN] = {.value = 3, .least = 0, .most = 255};
  open();
  LONGS_EQUAL(0, device.controls[V4L2_CID_AUTOGAIN].value);
  LONGS_EQUAL(12, device.controls[V4L2_CID_GAIN].value);
  DOUBLES_EQUAL(12.0, take_sent().gain, 0.0);
  settings.gain = 256.0;
  check_refused(Status::unsupported, "/dev/video0: gain of 256: takes 0 to 255");
}

TEST(V4l2Driver, ControlsOfTheCameraAreSetByName) {
  device.controls[V4L2_CID_USER_CLASS] = {.name = "User Controls", .type = V4L2_CTRL_TYPE_CTRL_CLASS};
  device.controls[V4L2_CID_USER_BASE + 0x1001] = {.value = 0, .least = 0, .most = 1, .name = "Trigger Mode"};
  device.controls[V4L2_CID_USER_BASE + 0x1002] = {.value = 0, .least = -5, .most = 5, .name = "(IO) Line, Edge "};
  settings.controls = {{"trigger_mode", 1}, {"io_line_edge", -5}};
  open();
  LONGS_EQUAL(1, device.controls[V4L2_CID_USER_BASE + 0x1001].value);
  LONGS_EQUAL(-5, device.controls[V4L2_CID_USER_BASE + 0x1002].value);
  settings.controls = {{"trigger_mode", 2}};
  check_refused(Status::unsupported, "/dev/video0: trigger_mode of 2: takes 0 to 1");
  settings.controls = {{"user_controls", 1}};
  check_refused(Status::unsupported, "/dev/video0: has no control user_controls; it has trigger_mode, io_line_edge");
  device.controls.clear();
  check_refused(Status::unsupported, "/dev/video0: has no control user_controls; it has none");
}

TEST(V4l2Driver, ThereIsNoSoftwareTrigger) {
  open();
  CHECK_TRUE(driver.trigger() == Status::unsupported);
  settings.trigger = Trigger::software;
  check_refused(Status::unsupported, "/dev/video0: V4L2 has no software trigger: free_running or line was expected");
}

// Streaming

TEST(V4l2Driver, WaitsNoLongerThanAsked) {
  CHECK_TRUE(driver.take(wait, image) == Status::not_configured);
  open();
  const Time before = clock.peek();
  CHECK_TRUE(driver.take({}, image) == Status::no_data);
  CHECK_TRUE(driver.take(Duration{-1}, image) == Status::no_data);
  LONGS_EQUAL(0, device.polls);
  CHECK_TRUE(clock.peek() == before);
  CHECK_TRUE(driver.take(wait, image) == Status::timeout);
  CHECK_TRUE(clock.peek() == before + wait);
}

TEST(V4l2Driver, WakingUpForNothingDoesNotSpin) {
  open();
  device.poll_extra = POLLIN;  // says there is one, gives none
  const std::size_t before = device.calls;
  CHECK_TRUE(driver.take(wait, image) == Status::timeout);
  CHECK_TRUE(device.calls - before < 20);
}

TEST(V4l2Driver, BuffersAreGivenBackOnce) {
  open();
  take_sent();
  CHECK_TRUE(driver.give_back(image.buffer + 1) == Status::stale_handle);
  CHECK_TRUE(driver.give_back(99) == Status::stale_handle);
  CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
  CHECK_TRUE(driver.give_back(image.buffer) == Status::stale_handle);
}

TEST(V4l2Driver, DamagedAndShortImagesAreNotComplete) {
  open();
  ScriptedVideo::Image sent = device.image();
  sent.flags |= V4L2_BUF_FLAG_ERROR;
  device.waiting.push_back(sent);
  CHECK_TRUE(driver.take(wait, image) == Status::ok);
  CHECK_FALSE(image.complete);
  CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
  sent = device.image();
  sent.bytes_used = 31;
  device.waiting.push_back(sent);
  CHECK_TRUE(driver.take(wait, image) == Status::ok);
  CHECK_FALSE(image.complete);
  LONGS_EQUAL(31, image.bytes.size());
  CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
  CHECK_TRUE(take_sent().complete);
}

TEST(V4l2Driver, ALastRowWithoutItsPaddingIsComplete) {
  device.padding = 8;
  open();
  ScriptedVideo::Image sent = device.image();
  sent.bytes_used = 3 * 16 + 8;
  device.waiting.push_back(sent);
  CHECK_TRUE(driver.take(wait, image) == Status::ok);
  CHECK_TRUE(image.complete);
}

TEST(V4l2Driver, AChangedResolutionIsALoss) {
  open();
  pass_sent();
  device.change_format(16, 8);
  ScriptedVideo::Image sent = device.image();
  sent.bytes_used = 20;
  device.waiting.push_back(sent);
  check_lost("/dev/video0: changed to 16 x 8 GREY while streaming 8 x 4 grey8");
  open();
  device.changed = true;
  check_lost("/dev/video0: its source has changed");
}

TEST(V4l2Driver, WithoutEventsItStreamsAllTheSame) {
  device.has_events = false;
  open();
  pass_sent();
}

TEST(V4l2Driver, ErrorsOfADeviceAreALoss) {
  open();
  device.poll_extra = POLLERR;
  check_lost("/dev/video0: gave up streaming");
  device.poll_extra = 0;
  open();
  device.answers = {{VIDIOC_DQBUF, -EIO}};
  check_lost("/dev/video0: waiting for an image: Input/output error");
  device.answers.clear();
  open();
  take_sent();
  device.present = false;
  check_lost("/dev/video0: waiting for an image: there is no device behind it");
  CHECK_TRUE(driver.give_back(image.buffer) == Status::device_lost);
}

// Stamps and numbers

TEST(V4l2Driver, StampsAreTheKernels) {
  settings.stamp_meaning = StampMeaning::mid_exposure;
  open();
  ScriptedVideo::Image sent = device.image();
  sent.stamp_us = 987'654;
  device.waiting.push_back(sent);
  CHECK_TRUE(driver.take(wait, image) == Status::ok);
  CHECK_TRUE(image.stamp == Time{987'654'000});
  CHECK_TRUE(image.clock == hal::ClockId::monotonic);
  CHECK_TRUE(image.stamp_meaning == StampMeaning::mid_exposure);  // "end of frame" tells nothing
  CHECK_TRUE(image.dequeued == clock.peek());
  CHECK_TRUE(image.first_data == clock.peek());
  sent = device.image();
  sent.flags |= V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  device.waiting.push_back(sent);
  CHECK_TRUE(driver.take(wait, image) == Status::ok);
  CHECK_TRUE(image.stamp_meaning == StampMeaning::start_of_exposure);
}

TEST(V4l2Driver, CopiedAndUnknownStampsAreTheDevices) {
  open();
  const auto clock_of = [&](std::uint32_t flags, std::int64_t stamp_us) {
    ScriptedVideo::Image sent = device.image();
    sent.flags = flags;
    sent.stamp_us = stamp_us;
    device.waiting.push_back(sent);
    CHECK_TRUE(driver.take(wait, image) == Status::ok);
    CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
    return image.clock;
  };
  CHECK_TRUE(clock_of(V4L2_BUF_FLAG_TIMESTAMP_COPY, 999'000) == hal::ClockId::device);
  CHECK_TRUE(clock_of(V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN, 1'700'000'000'000'000) == hal::ClockId::device);
  CHECK_TRUE(image.stamp == Time{1'700'000'000'000'000'000});
  CHECK_TRUE(clock_of(V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN, 999'000) == hal::ClockId::monotonic);
  CHECK_TRUE(clock_of(V4L2_BUF_FLAG_TIMESTAMP_COPY, 0) == hal::ClockId::monotonic);  // none at all
  CHECK_TRUE(image.stamp == clock.peek());
}

TEST(V4l2Driver, SequenceBeginsAtNoneAndShowsGaps) {
  open();
  device.skip_sequence(5000);  // a loopback device that was written to before
  LONGS_EQUAL(0, pass_sent().sequence);
  LONGS_EQUAL(1, pass_sent().sequence);
  device.skip_sequence(3);
  LONGS_EQUAL(5, pass_sent().sequence);
  CHECK_TRUE(image.has_sequence);
}

TEST(V4l2Driver, ASequenceThatStandsStillIsNone) {
  open();
  for (int k = 0; k < 3; ++k) {
    ScriptedVideo::Image sent = device.image();
    sent.sequence = 0;
    device.waiting.push_back(sent);
    CHECK_TRUE(driver.take(wait, image) == Status::ok);
    CHECK_TRUE(driver.give_back(image.buffer) == Status::ok);
    CHECK_TRUE(image.has_sequence == (k == 0));
  }
  open();
  CHECK_TRUE(pass_sent().has_sequence);  // judged anew
}

TEST(V4l2Driver, TakesNoHeapPerImage) {
  open();
  pass_sent();
  for (int k = 0; k < 4; ++k) device.send();
  std::size_t good = 0;
  std::size_t allocations = 0;
  {
    const test::AllocationTrap trap;
    for (int k = 0; k < 4; ++k) {
      if (driver.take(wait, image) == Status::ok) ++good;
      allocations = trap.allocations();  // the played device allocates in its queue
    }
  }
  LONGS_EQUAL(4, good);
  LONGS_EQUAL(0, allocations);
}

// With the camera that it is made for

TEST(V4l2Driver, AHundredUnpluggingsLeaveNothingBehind) {
  StreamCamera camera(driver, clock, settings);
  CHECK_TRUE(camera.start() == Status::ok);
  for (int cycle = 0; cycle < 100; ++cycle) {
    hal::Frame frame;
    device.send();
    CHECK_TRUE(camera.acquire(wait, frame) == Status::ok);
    CHECK_TRUE(camera.release(frame) == Status::ok);
    device.send();
    CHECK_TRUE(camera.acquire(wait, frame) == Status::ok);
    device.present = false;
    hal::Frame none;
    CHECK_TRUE(camera.acquire(wait, none) == Status::device_lost);
    LONGS_EQUAL(8, device.mappings());  // until the frame in use is given back
    CHECK_TRUE(camera.release(frame) == Status::ok);
    check_nothing_left();
    CHECK_TRUE(camera.start() == Status::no_data);
    STRCMP_EQUAL("/dev/video0: does not exist", camera.problem().c_str());
    device.present = true;
    clock.advance(camera.until_next_attempt());
    CHECK_TRUE(camera.start() == Status::ok);
  }
  LONGS_EQUAL(101, device.opens);
  LONGS_EQUAL(100, camera.counts().reconnects);
  LONGS_EQUAL(200, camera.counts().delivered);
  CHECK_TRUE(camera.stop() == Status::ok);
  check_nothing_left();
}
