#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "fsw/app/flight_config.hpp"
#include "platform/files/udp_address.hpp"

namespace relnav {

/// Where a camera is and what it is told. Names as in the file; what is empty, 0 or negative was not given.
struct CameraSource {
  enum class Kind : std::uint8_t { v4l2, aravis };
  enum class Trigger : std::uint8_t { free_running, software, line };
  enum class Stamps : std::uint8_t { start_of_exposure, mid_exposure, end_of_exposure, original };

  Kind kind = Kind::v4l2;
  std::string device;  ///< v4l2: the device node; aravis: name, address or serial number
  std::string serial;
  std::string format;
  double rate_hz = 0.0;
  double exposure_us = 0.0;
  double gain = -1.0;
  bool gain_in_db = false;  ///< what one unit of the camera's gain means, for automatic exposure: decibels, or a factor
  double gain_step = 1.0;   ///< and how much of it
  Trigger trigger = Trigger::free_running;
  Stamps stamps = Stamps::end_of_exposure;
  bool copy_frames = false;
  std::uint32_t packet_bytes = 0;
  std::uint32_t socket_buffer_bytes = 0;
};

/// Lines of one chip, by name or offset; empty: not wired.
struct LineNames {
  std::string chip;
  std::string strobe;
  std::string heartbeat;
  std::string pulse;
  std::string exposure;
};

struct TelemetryOutput {
  enum class Kind : std::uint8_t { udp, file, serial };
  Kind kind = Kind::udp;
  UdpAddress address;      ///< udp
  std::string path;        ///< file, serial
  std::uint32_t baud = 0;  ///< serial
};

/// The one configuration file of relnav-flight, with the files that it names.
struct FlightFile {
  app::FlightLoopConfig loop;  ///< lines are not resolved yet
  CameraSource camera;
  std::optional<CameraSource> second;
  LineNames lines;
  TelemetryOutput telemetry;
  std::optional<UdpAddress> telecommands;
  bool lock_memory = true;
  int priority = 0;             ///< SCHED_FIFO; 0: none
  std::int64_t tai_utc_s = 37;  ///< TAI - UTC (since 2017-01-01), to name the seconds of pulses by the system's clock
};

/// Reads and checks all of it. Paths in the file are relative to the file. Throws InputError: unknown keys, wrong types, values
/// outside their domain or in contradiction to each other, with file and line.
[[nodiscard]] FlightFile read_flight_file(const std::string& path);

}  // namespace relnav
