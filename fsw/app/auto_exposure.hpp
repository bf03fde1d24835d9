#pragma once
#include <cstdint>

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "fsw/vision/brightness.hpp"
#include "hal/exposure_control.hpp"

namespace relnav::app {

/// What to do when nothing bright is seen: in eclipse, or because the exposure is far too short.
enum class DarkAction : std::uint8_t {
  hold,   ///< stay where it is
  raise,  ///< expose longer, and then amplify more, up to the limits
};

/// Of all cameras alike. Levels are of 255. The limits of the device hold as well, and go before these.
struct AutoExposureConfig {
  bool enabled = false;
  vision::BrightnessSettings brightness;
  std::uint8_t target_level = 160;        ///< of the bright part, see bright_permille
  std::uint8_t ceiling_level = 225;       ///< all but saturated_permille of it stay under this
  std::uint8_t black_level = 0;           ///< of a pixel without any light
  double dead_band = 1.15;                ///< off by less than this factor: nothing is done
  double max_step = 4.0;                  ///< largest factor of one correction
  std::uint16_t settle_frames = 3;        ///< after a command not judged: at least how many still show the one before
  std::uint16_t min_bright_samples = 16;  ///< fewer count as dark
  std::uint16_t dark_frames = 10;         ///< so many in a row before the action is taken
  DarkAction when_dark = DarkAction::hold;
  Duration exposure_min{50'000};
  Duration exposure_max{20'000'000};  ///< by motion blur
  Duration exposure_start{1'000'000};
  double gain_min = 1.0;
  double gain_max = 16.0;

  [[nodiscard]] bool is_valid() const;
};

/// What was done about the exposure of one camera in a step.
struct ExposureReport {
  Status status = Status::no_data;  ///< of the device; no_data: it was not spoken to
  bool measured = false;            ///< `brightness` is of a frame of this step
  bool judged = false;              ///< and it was held against what it should be
  bool dark = false;                ///< nothing bright in it
  bool changed = false;             ///< another exposure is in force from a later frame on
  vision::Brightness brightness;
  hal::Exposure exposure;  ///< applied latest; time 0: none yet
};

/// Chooses exposure time and gain of one camera, so that the bright part of the target is exposed right; space fills most of an
/// image and says nothing. One correction by the factor that is wanting, then frames that may still be of the exposure before
/// are let pass: with a delay of up to settle_frames + 1 frames nothing is corrected twice. Time goes first, up to exposure_max,
/// then gain. What is over-exposed does not tell by how much: it goes down by max_step. The same frames give the same commands.
class AutoExposure {
 public:
  /// `control` may be null: nothing happens then.
  explicit AutoExposure(hal::ExposureControl* control) : control_(control) {}

  /// Begins anew: exposure_start and least gain at the next serve(). `config` is valid.
  void configure(const AutoExposureConfig& config);
  [[nodiscard]] bool is_on() const { return control_ != nullptr && config_.enabled; }
  /// Once a step while the camera streams. `brightness`: of a frame of this step; null: none came.
  [[nodiscard]] ExposureReport serve(const vision::Brightness* brightness);

 private:
  [[nodiscard]] bool is_dark(const vision::Brightness& brightness) const;
  /// What exposure times gain should be multiplied by.
  [[nodiscard]] double correction(const vision::Brightness& brightness) const;
  /// `product`: time (ns) times gain that is wanted.
  [[nodiscard]] static hal::Exposure share_out(double product, const hal::ExposureLimits& limits);
  [[nodiscard]] Status usable_limits(hal::ExposureLimits& limits) const;
  void command(double product, ExposureReport& report);
  /// For a device of coarse steps: what the one has too much of, gain or time, the other makes up for.
  Status make_up(double product, const hal::Exposure& wanted, const hal::ExposureLimits& limits);
  Status apply(const hal::Exposure& wanted);
  [[nodiscard]] bool is_near(double product, double wanted) const;

  hal::ExposureControl* control_;
  AutoExposureConfig config_;
  hal::Exposure wanted_;   ///< asked for latest
  hal::Exposure applied_;  ///< and what the device made of it
  bool has_applied_ = false;
  std::uint16_t to_settle_ = 0;  ///< frames that are not judged
  std::uint16_t dark_in_a_row_ = 0;
};

}  // namespace relnav::app
