#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace relnav {

/// printf into a string.
[[gnu::format(printf, 1, 2)]] std::string format_text(const char* format, ...);

[[nodiscard]] std::string_view trimmed(std::string_view text);
/// Cut at every `separator`; parts are trimmed, empty ones are kept.
[[nodiscard]] std::vector<std::string_view> split(std::string_view text, char separator);
/// Cut at white space; no empty parts.
[[nodiscard]] std::vector<std::string_view> split_words(std::string_view text);

/// The whole of `text` as a number (infinities and NaN included).
[[nodiscard]] std::optional<double> parse_double(std::string_view text);
[[nodiscard]] std::optional<std::int64_t> parse_int64(std::string_view text);
/// Decimal seconds, with or without exponent, to the nearest nanosecond without passing through a float.
[[nodiscard]] std::optional<std::int64_t> parse_seconds_to_ns(std::string_view text);
/// Seconds with nine decimals, exact.
[[nodiscard]] std::string format_seconds(std::int64_t ns);

/// Every line of a file without its line end; throws InputError when it cannot be read.
[[nodiscard]] std::vector<std::string> read_lines(const std::string& path);
/// The whole file; throws InputError when it cannot be read.
[[nodiscard]] std::string read_text(const std::string& path);
/// Shortens a piece of bad input for a message and makes it printable.
[[nodiscard]] std::string in_quotes(std::string_view text);

}  // namespace relnav
