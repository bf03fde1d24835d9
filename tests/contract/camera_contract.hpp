#pragma once
/// Contract of hal::Camera. A harness has:
///   hal::Camera& camera();         not started
///   bool offer_frame();            makes the next good frame of the source available
///   bool offer_damaged_frame();    makes the next frame of the source arrive damaged; false: cannot be played here
///   bool lose_device();            false: cannot be played here
///   void restore_device();
///   Duration wait();               long enough for an offered frame to arrive
///   Time now();                    on the clock that waiting uses up
///   Duration slack();              how inexact waiting is on that clock
#include <algorithm>
#include <cstdint>
#include <vector>

#include "hal/camera.hpp"
#include "tests/contract/clause.hpp"

namespace relnav::camera_contract {

inline hal::Frame untouched() {
  hal::Frame frame;
  frame.sequence = 0xDEADBEEF;
  frame.lease = 0xDEADBEEF;
  frame.width_px = 12345;
  return frame;
}
inline bool is_untouched(const hal::Frame& frame) {
  return frame.sequence == 0xDEADBEEF && frame.lease == 0xDEADBEEF && frame.width_px == 12345 &&
         frame.pixels == nullptr;
}
inline std::uint32_t row_bytes(const hal::Frame& frame) {
  return frame.width_px * (frame.format == hal::PixelFormat::mono16 ? 2U : 1U);
}
inline std::vector<std::uint8_t> copy_of(const hal::Frame& frame) {
  std::vector<std::uint8_t> copy;
  for (std::uint32_t v = 0; v < frame.height_px; ++v) {
    const std::uint8_t* row = frame.pixels + std::size_t{v} * frame.stride_bytes;
    copy.insert(copy.end(), row, row + row_bytes(frame));
  }
  return copy;
}

template <typename Harness>
hal::Frame take(Harness& harness) {
  CHECK_TRUE(harness.offer_frame());
  hal::Frame frame;
  CHECK_TRUE(harness.camera().acquire(harness.wait(), frame) == Status::ok);
  return frame;
}

template <typename Harness>
void CAM_1_acquire_before_start_is_not_configured(Harness& harness) {
  CHECK_TRUE(harness.offer_frame());
  hal::Frame frame = untouched();
  CHECK_TRUE(harness.camera().acquire(harness.wait(), frame) == Status::not_configured);
  CHECK_TRUE(is_untouched(frame));
}

template <typename Harness>
void CAM_2_pixels_stay_until_release(Harness& harness) {
  CHECK_TRUE(harness.camera().start() == Status::ok);
  const hal::Frame held = take(harness);
  const std::vector<std::uint8_t> before = copy_of(held);
  const std::uint32_t others = harness.camera().max_leases() > 1 ? 3 * harness.camera().max_leases() : 0;
  for (std::uint32_t i = 0; i < others; ++i) {
    const hal::Frame other = take(harness);
    CHECK_TRUE(other.pixels != held.pixels);
    CHECK_TRUE(copy_of(held) == before);
    CHECK_TRUE(harness.camera().release(other) == Status::ok);
  }
  CHECK_TRUE(copy_of(held) == before);
  CHECK_TRUE(harness.camera().release(held) == Status::ok);
}

template <typename Harness>
void CAM_2_frame_is_unchanged_without_success(Harness& harness) {
  CHECK_TRUE(harness.camera().start() == Status::ok);
  hal::Frame frame = untouched();
  CHECK_TRUE(harness.camera().acquire(Duration{0}, frame) != Status::ok);
  CHECK_TRUE(is_untouched(frame));
}

template <typename Harness>
void CAM_3_never_waits_longer_than_asked(Harness& harness) {
  CHECK_TRUE(harness.camera().start() == Status::ok);
  for (const std::int64_t wait_ns : {std::int64_t{0}, std::int64_t{5'000'000}}) {
    hal::Frame frame = untouched();
    const Time before = harness.now();
    const Status status = harness.camera().acquire(Duration{wait_ns}, frame);
    const Duration waited = harness.now() - before;
    CHECK_TRUE(status == Status::no_data || status == Status::timeout);
    CHECK_TRUE(waited.ns <= wait_ns + harness.slack().ns);
    CHECK_TRUE(is_untouched(frame));
  }
}

template <typename Harness>
void CAM_4_leases_are_bounded(Harness& harness) {
  CHECK_TRUE(harness.camera().start() == Status::ok);
  CHECK_TRUE(harness.camera().max_leases() >= 1);
  std::vector<hal::Frame> frames;
  for (std::uint32_t i = 0; i < harness.camera().max_leases(); ++i) frames.push_back(take(harness));
  CHECK_TRUE(harness.offer_frame());
  hal::Frame more = untouched();
  CHECK_TRUE(harness.camera().acquire(harness.wait(), more) == Status::no_capacity);
  CHECK_TRUE(is_untouched(more));
  CHECK_TRUE(harness.camera().release(frames.back()) == Status::ok);
  frames.pop_back();
  CHECK_TRUE(harness.camera().acquire(harness.wait(), more) == Status::ok);
  frames.push_back(more);
  for (const hal::Frame& frame : frames) CHECK_TRUE(harness.camera().release(frame) == Status::ok);
}

template <typename Harness>
void CAM_5_release_of_what_is_not_out_is_stale(Harness& harness) {
  CHECK_TRUE(harness.camera().start() == Status::ok);
  CHECK_TRUE(harness.camera().release(hal::Frame{}) == Status::stale_handle);
  const hal::Frame frame = take(harness);
  hal::Frame other = frame;
  other.lease = frame.lease + 1000;
  CHECK_TRUE(harness.camera().release(other) == Status::stale_handle);
  CHECK_TRUE(harness.camera().release(frame) == Status::ok);
  CHECK_TRUE(harness.camera().release(frame) == Status::stale_handle);
  // The lease's successor is not hit by the old name.
  const hal::Frame successor = take(harness);
  CHECK_TRUE(harness.camera().release(frame) == Status::stale_handle);
  CHECK_TRUE(harness.camera().release(successor) == Status::ok);
}

template <typename Harness>
void CAM_6_damaged_frames_are_not_handed_out(Harness& harness) {
  CHECK_TRUE(harness.camera().start() == Status::ok);
  const hal::Frame before = take(harness);
  CHECK_TRUE(harness.camera().release(before) == Status::ok);
  if (!harness.offer_damaged_frame()) return;
  hal::Frame frame = untouched();
  CHECK_TRUE(harness.camera().acquire(harness.wait(), frame) == Status::incomplete);
  CHECK_TRUE(is_untouched(frame));
  const hal::Frame after = take(harness);
  CHECK_TRUE(after.sequence >= before.sequence + 2);
  CHECK_TRUE(harness.camera().release(after) == Status::ok);
}

template <typename Harness>
void CAM_7_sequence_numbers_increase(Harness& harness) {
  CHECK_TRUE(harness.camera().start() == Status::ok);
  hal::Frame last = take(harness);
  CHECK_TRUE(harness.camera().release(last) == Status::ok);
  for (int i = 0; i < 10; ++i) {
    const hal::Frame frame = take(harness);
    CHECK_TRUE(frame.sequence > last.sequence);
    CHECK_TRUE(harness.camera().release(frame) == Status::ok);
    last = frame;
  }
}

template <typename Harness>
void CAM_8_lost_until_started_again(Harness& harness) {
  CHECK_TRUE(harness.camera().start() == Status::ok);
  if (!harness.lose_device()) return;
  hal::Frame frame = untouched();
  for (int i = 0; i < 3; ++i) {
    CHECK_TRUE(harness.camera().acquire(harness.wait(), frame) == Status::device_lost);
    CHECK_TRUE(is_untouched(frame));
  }
  CHECK_TRUE(harness.camera().start() != Status::ok);
  CHECK_TRUE(harness.camera().acquire(harness.wait(), frame) == Status::device_lost);
  harness.restore_device();
  CHECK_TRUE(harness.camera().acquire(harness.wait(), frame) == Status::device_lost);
  CHECK_TRUE(harness.camera().start() == Status::ok);
  CHECK_TRUE(harness.camera().release(take(harness)) == Status::ok);
}

template <typename Harness>
void CAM_9_stop_keeps_leases(Harness& harness) {
  CHECK_TRUE(harness.camera().start() == Status::ok);
  const hal::Frame held = take(harness);
  const std::vector<std::uint8_t> before = copy_of(held);
  CHECK_TRUE(harness.camera().stop() == Status::ok);
  hal::Frame frame = untouched();
  CHECK_TRUE(harness.camera().acquire(harness.wait(), frame) == Status::not_configured);
  CHECK_TRUE(is_untouched(frame));
  CHECK_TRUE(copy_of(held) == before);
  CHECK_TRUE(harness.camera().release(held) == Status::ok);
  CHECK_TRUE(harness.camera().start() == Status::ok);
  CHECK_TRUE(harness.camera().release(take(harness)) == Status::ok);
}

template <typename Harness>
void CAM_10_frames_are_well_formed(Harness& harness) {
  CHECK_TRUE(harness.camera().start() == Status::ok);
  std::vector<hal::Frame> frames;
  for (std::uint32_t i = 0; i < harness.camera().max_leases(); ++i) {
    const hal::Frame frame = take(harness);
    CHECK_TRUE(frame.pixels != nullptr);
    CHECK_TRUE(frame.width_px > 0);
    CHECK_TRUE(frame.height_px > 0);
    CHECK_TRUE(frame.stride_bytes >= row_bytes(frame));
    for (const hal::Frame& other : frames) CHECK_TRUE(other.lease != frame.lease);
    frames.push_back(frame);
  }
  for (const hal::Frame& frame : frames) CHECK_TRUE(harness.camera().release(frame) == Status::ok);
}

}  // namespace relnav::camera_contract

#define RELNAV_CAMERA_CONTRACT(group, Harness)                                                \
  TEST_GROUP(group) { Harness harness; };                                                     \
  RELNAV_CLAUSE(group, relnav::camera_contract, CAM_1_acquire_before_start_is_not_configured) \
  RELNAV_CLAUSE(group, relnav::camera_contract, CAM_2_pixels_stay_until_release)              \
  RELNAV_CLAUSE(group, relnav::camera_contract, CAM_2_frame_is_unchanged_without_success)     \
  RELNAV_CLAUSE(group, relnav::camera_contract, CAM_3_never_waits_longer_than_asked)          \
  RELNAV_CLAUSE(group, relnav::camera_contract, CAM_4_leases_are_bounded)                     \
  RELNAV_CLAUSE(group, relnav::camera_contract, CAM_5_release_of_what_is_not_out_is_stale)    \
  RELNAV_CLAUSE(group, relnav::camera_contract, CAM_6_damaged_frames_are_not_handed_out)      \
  RELNAV_CLAUSE(group, relnav::camera_contract, CAM_7_sequence_numbers_increase)              \
  RELNAV_CLAUSE(group, relnav::camera_contract, CAM_8_lost_until_started_again)               \
  RELNAV_CLAUSE(group, relnav::camera_contract, CAM_9_stop_keeps_leases)                      \
  RELNAV_CLAUSE(group, relnav::camera_contract, CAM_10_frames_are_well_formed)
