#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace relnav::hil {

/// What a served camera does wrong, from frame `frame` (counted from 0) on.
enum class FaultKind : std::uint8_t {
  lost,       ///< `count` frames are never sent
  frozen,     ///< `count` frames show the image before them again, under their own stamps
  torn,       ///< the lower half of `count` frames is that of the image before
  black,      ///< `count` frames
  white,      ///< `count` frames
  time_jump,  ///< stamps go on shifted by `amount` seconds
  packets,    ///< of the packets of `count` frames `amount` in a thousand are lost
  unplug,     ///< the camera is away for `amount` milliseconds
};

struct Fault {
  FaultKind kind = FaultKind::lost;
  std::uint64_t frame = 0;
  std::uint64_t count = 1;
  double amount = 0.0;

  [[nodiscard]] bool hits(std::uint64_t number) const { return number >= frame && number - frame < count; }
};

/// How parse_fault() wants it, for --help and messages.
inline constexpr const char* fault_syntax =
    "{lost,frozen,torn,black,white}@FRAME[:COUNT], time_jump@FRAME:SECONDS, packets@FRAME:COUNT[:PER_THOUSAND], "
    "unplug@FRAME:MILLISECONDS";

/// Throws InputError.
[[nodiscard]] Fault parse_fault(std::string_view text);

}  // namespace relnav::hil
