#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "hal/camera.hpp"
#include "hal/exposure_control.hpp"
#include "hil/replay/run_camera.hpp"
#include "hil/serve/fault.hpp"
#include "hil/simulation/simulated_clock.hpp"

namespace relnav::hil {

/// A frame to be taken.
struct PlannedFrame {
  Time time;   ///< mid-exposure, true
  Time stamp;  ///< as the camera states it, jumps of its clock included
};

/// What a frame shows, exposed so.
using FrameMaker = std::function<void(std::size_t number, const hal::Exposure&, Image&)>;

/// Camera over frames that are made when they are asked for. Behind the HAL it behaves as a real one: a frame comes when it has been
/// exposed and read out, some never come, and with a fault `unplug` the device is away. Stamps are of ClockId::device, unless
/// an exposure line tells of the exposures by the loop's clock, too: latencies are the machine's then, and differ from run to run.
class SimulatedCamera final : public hal::Camera, public hal::ExposureControl, public RunCamera {
 public:
  SimulatedCamera(std::vector<PlannedFrame> frames, std::vector<Fault> faults, SimulatedClock& clock, FrameMaker make,
                  const hal::Exposure& exposure);

  Status start() override;
  Status acquire(Duration wait, hal::Frame& frame) override;
  Status release(const hal::Frame& frame) override;
  Status stop() override;
  [[nodiscard]] std::uint32_t max_leases() const override { return static_cast<std::uint32_t>(slots_.size()); }

  /// Where it says when it exposes; its frames have stamps of the loop's clock then. Before the first start().
  void wire_exposures(std::function<void(Time begin, Time end)> line) { exposure_line_ = std::move(line); }
  /// While it is stopped: waits until the next frame is past, which nobody sees.
  void let_pass();
  /// The device is away for so long of simulated time.
  void unplug(Duration away);

  Status limits(hal::ExposureLimits& limits) override;
  /// In force from the frame after the next one: that one is being exposed.
  Status set(const hal::Exposure& wanted, hal::Exposure& applied) override;

  /// What was set last.
  [[nodiscard]] const hal::Exposure& commanded() const { return next_exposure_; }

  [[nodiscard]] std::size_t frames_listed() const override { return frames_.size(); }
  [[nodiscard]] std::size_t frames_done() const override;
  [[nodiscard]] const ImageEntry& last_entry() const override { return last_; }
  [[nodiscard]] const std::string& problem() const override { return problem_; }

 private:
  struct Slot {
    std::shared_ptr<Image> image;
    std::uint32_t lease = 0;  ///< 0: free
  };
  [[nodiscard]] const Fault* fault_at(FaultKind kind, std::size_t number) const;
  [[nodiscard]] Time due(std::size_t number) const;
  [[nodiscard]] bool is_away() const;
  [[nodiscard]] const hal::Exposure& exposure_of(std::size_t number) const;
  /// Status::timeout or no_data while that frame is not there yet.
  Status await_due(std::size_t number, Duration wait);
  /// The image of frame `number` with its faults.
  std::shared_ptr<Image> expose(std::size_t number);

  std::vector<PlannedFrame> frames_;
  std::vector<Fault> faults_;
  SimulatedClock& clock_;
  FrameMaker make_;
  std::function<void(Time, Time)> exposure_line_;  ///< empty: none
  hal::Exposure exposure_;                         ///< before frame changed_from_
  hal::Exposure next_exposure_;
  std::size_t changed_from_ = 0;
  std::array<Slot, 3> slots_;
  std::shared_ptr<Image> shown_;  ///< last one handed out
  std::size_t next_ = 0;
  bool streaming_ = false;
  bool lost_ = false;  ///< until the next start()
  Time back_;          ///< when the unplugged device is there again
  std::uint32_t last_lease_ = 0;
  ImageEntry last_;
  std::string problem_;
};

}  // namespace relnav::hil
