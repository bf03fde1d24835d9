#pragma once
#include <cstdint>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "platform/linux/aravis_session.hpp"
#include "platform/linux/aravis_settings.hpp"
#include "platform/linux/block_id_counter.hpp"
#include "platform/linux/camera_driver.hpp"
#include "platform/linux/exposure_in_force.hpp"

namespace relnav::platform::linux {

/// GigE Vision and USB3 Vision cameras through Aravis. Stamps are the camera's own (ClockId::device), where it has none the
/// arrival of the first packet. A frame with a missing packet comes as incomplete. A camera that vanishes is noticed by Aravis'
/// heartbeat only after up to 6 s: take() answers timeout until then.
class AravisDriver final : public CameraDriver {
 public:
  AravisDriver() = default;
  AravisDriver(const AravisDriver&) = delete;
  AravisDriver& operator=(const AravisDriver&) = delete;
  /// Waits until a camera that has vanished is taken down: up to 10 s.
  ~AravisDriver() override;

  /// Looks for an address at most 0.3 s, for a name as long as Aravis' discovery takes (about 1 s). A camera that vanishes
  /// while it is opened costs 3 s.
  Status open(const CameraSettings& settings) override;
  /// At most 0.5 s: a camera that has vanished is taken down in the background (of 17 within 10 s, the last waits for the first).
  void close() override;
  Status take(Duration wait, RawImage& image) override;
  Status give_back(std::uint32_t buffer) override;
  Status trigger() override;
  Status exposure_range(ExposureRange& range) override;
  /// Some milliseconds on a network, at most 20. timeout: no answer until then; it may come yet.
  Status adjust(ExposureValues& values) override;
  [[nodiscard]] std::uint32_t max_loans() const override;
  [[nodiscard]] std::uint64_t underruns() const override;
  [[nodiscard]] const std::string& problem() const override { return problem_; }

 private:
  Status connect(const CameraSettings& settings);
  Status check_serial(const CameraSettings& settings);
  Status start_stream(const CameraSettings& settings);
  void take_adjusted();
  void note(const AravisSession::Adjusted& adjusted);
  void describe(ArvBuffer* buffer, RawImage& image);

  std::unique_ptr<AravisSession> session_;
  std::vector<std::future<void>> former_;  ///< sessions that are being taken down
  std::vector<bool> on_loan_;
  AppliedSettings applied_;
  ExposureRange range_;  ///< asked for once, before it streams
  Status range_status_ = Status::not_configured;
  ExposureInForce in_force_;
  StampMeaning stamp_meaning_ = StampMeaning::end_of_exposure;
  BlockIdCounter counter_;
  std::string name_;
  std::string problem_;
};

}  // namespace relnav::platform::linux
