#pragma once
#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "fsw/app/flight_config.hpp"
#include "hil/dynamics/motion_settings.hpp"
#include "hil/serve/fault.hpp"
#include "hil/simulation/simulated_commands.hpp"
#include "hil/simulation/simulated_lines.hpp"
#include "platform/files/camera_file.hpp"

namespace relnav::hil {

/// What the flight code is fed with.
enum class SensorKind : std::uint8_t {
  images,    ///< rendered frames, through the whole flight loop
  features,  ///< feature observations, straight into the estimator: no images, for fast statistics
};

/// Observations of `sensor: features`.
struct FeatureSettings {
  int count = 40;                          ///< most features at a time (noncoop)
  double sigma_px = 0.3;                   ///< of each coordinate
  double first_view_sigma_px = 0.1;        ///< of the view a feature is defined by
  double outlier_share = 0.0;              ///< of the observations,
  double outlier_px = 20.0;                ///< off by up to this much in each coordinate
  double missed_share = 0.0;               ///< of those in sight
  bool opaque_body = false;                ///< lights behind the box of half_size_m are hidden
  int body_points = 400;                   ///< on the target's surface (noncoop),
  Vec3 half_size_m = Vec3(0.8, 0.8, 0.8);  ///< a box
};

/// What is wrong about the camera that the flight is told of: true value minus the calibration's.
struct CalibrationError {
  double fu_px = 0.0, fv_px = 0.0, cu_px = 0.0, cv_px = 0.0, k1 = 0.0;
};

/// A pose counts as wrong when it is off by more than `sigmas` of its own covariance and by more than the rest says.
struct WrongPoseLimits {
  double sigmas = 5.0;
  double position_of_range = 0.02;
  double attitude_rad = 0.02;
};

/// A figure that a paper states or that the project wants, for the report.
struct ReferenceFigure {
  std::string name;                               ///< as in figures_of()
  double paper = -1.0, must = -1.0, goal = -1.0;  ///< negative: none
};

/// Another kind of navigation from a moment on, as a ground command would have it.
struct Handover {
  double at_s = -1.0;  ///< negative: never
  app::NavigationKind navigation = app::NavigationKind::coop_mono;
};

/// A scenario as its file has it, with the dispersions of one run applied.
struct SimulationScenario {
  std::string path;
  std::string name;    ///< of the file, without its ending
  std::string source;  ///< where it is from
  std::uint64_t seed = 1;
  double duration_s = 30.0;
  double rate_hz = 10.0;
  SensorKind sensor = SensorKind::images;
  app::NavigationKind navigation = app::NavigationKind::noncoop;
  std::vector<CameraCalibration> cameras;  ///< as the flight is told
  std::vector<std::string> camera_files;
  CalibrationError calibration_error;
  TargetModel target;       ///< lights; empty: none
  std::string target_file;  ///< empty: none
  MotionSettings motion;
  FeatureSettings features;
  YAML::Node render;  ///< section `render`, read by whoever renders; undefined: defaults
  app::FlightLoopConfig flight;
  double exposure_s = 0.002;
  double gain = 1.0;
  double stamp_jitter_s = 0.0;  ///< 1 sigma of each stamp against the true mid-exposure
  std::vector<Fault> faults;
  Handover handover;
  LineSettings lines;
  std::vector<PlannedCommand> commands;  ///< by time
  WrongPoseLimits wrong;
  std::vector<ReferenceFigure> reference;
  std::map<std::string, double> dispersed;  ///< what was drawn, by the key's full name
  std::uint32_t crc = 0;                    ///< CRC-32 of the file and of all files that it names
};

/// Which run of a campaign: 0 is the scenario as it stands, without dispersions; from 1 on each is a seed of its own.
struct RunNumber {
  std::uint64_t number = 0;
};

/// Seed of a run: the scenario's for run 0, else mixed from both (splitmix64; Steele, Lea, Flood, OOPSLA 2014).
[[nodiscard]] std::uint64_t seed_of_run(std::uint64_t scenario_seed, RunNumber run);

/// Throws InputError with the line: unknown or missing keys, wrong types, contradictions, impossible geometry.
[[nodiscard]] SimulationScenario read_scenario(const std::string& path, RunNumber run = {});

}  // namespace relnav::hil
