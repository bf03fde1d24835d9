#pragma once
#include <cstdint>

namespace relnav {

/// Outcome of an operation. Errors are values: a caller must look at every one.
enum class [[nodiscard]] Status : std::uint8_t{
    ok = 0,                 ///< done
    invalid_argument,       ///< an argument is outside its stated domain
    not_configured,         ///< used before a successful configure()
    no_capacity,            ///< a bounded container or pool is full
    stale_handle,           ///< the slot was given to somebody else since the handle was made
    no_data,                ///< nothing to read now; try again later
    timeout,                ///< the bounded wait has run out
    device_lost,            ///< the device is gone; it needs to be reopened
    io_error,               ///< the device answered with an error
    incomplete,             ///< data arrived damaged or in part and must not be used
    out_of_order,           ///< a time stamp repeats or goes back
    outside_domain,         ///< outside the domain of validity of a model (e.g. distortion)
    behind_camera,          ///< a point has no image: it lies at or behind the projection centre
    not_positive_definite,  ///< a factorisation met a pivot that is not positive
    rank_deficient,         ///< the data do not determine the unknowns
    no_convergence,         ///< the iteration limit was reached
    too_few_features,       ///< fewer features than the problem needs
    not_finite,             ///< a NaN or infinity was met
    crc_mismatch,           ///< checksum over the received bytes is wrong
    unsupported,            ///< well formed, but not something this build can do
    ambiguous,              ///< another answer explains the data as well
    inconsistent,           ///< the data contradict each other or the model: chi-square alarm
    unfinished,             ///< the work of one call is bounded, and there is more: call again
};

/// Stable English identifier, for events and logs.
[[nodiscard]] constexpr const char* to_string(Status status) {
  switch (status) {
    case Status::ok: return "ok";
    case Status::invalid_argument: return "invalid_argument";
    case Status::not_configured: return "not_configured";
    case Status::no_capacity: return "no_capacity";
    case Status::stale_handle: return "stale_handle";
    case Status::no_data: return "no_data";
    case Status::timeout: return "timeout";
    case Status::device_lost: return "device_lost";
    case Status::io_error: return "io_error";
    case Status::incomplete: return "incomplete";
    case Status::out_of_order: return "out_of_order";
    case Status::outside_domain: return "outside_domain";
    case Status::behind_camera: return "behind_camera";
    case Status::not_positive_definite: return "not_positive_definite";
    case Status::rank_deficient: return "rank_deficient";
    case Status::no_convergence: return "no_convergence";
    case Status::too_few_features: return "too_few_features";
    case Status::not_finite: return "not_finite";
    case Status::crc_mismatch: return "crc_mismatch";
    case Status::unsupported: return "unsupported";
    case Status::ambiguous: return "ambiguous";
    case Status::inconsistent: return "inconsistent";
    case Status::unfinished: return "unfinished";
  }
  return "unknown";
}

}  // namespace relnav
