#pragma once

namespace relnav::test {

/// Sanitizers and emulators take some ten times as long: campaigns of many runs are cut short there.
#ifdef RELNAV_SHORT_CAMPAIGNS
inline constexpr bool short_campaigns = true;
#else
inline constexpr bool short_campaigns = false;
#endif

template <typename T>
constexpr T campaign(T whole, T cut) {
  return short_campaigns ? cut : whole;
}

}  // namespace relnav::test
