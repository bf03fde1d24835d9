#include "hil/io/covariance_csv.hpp"

#include <cmath>

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

constexpr std::size_t columns = 22;

TimedCovariance parse_row(const std::string& path, int line, std::string_view text) {
  const auto parts = split(text, ',');
  if (parts.size() != columns) {
    throw InputError(path, line, std::to_string(parts.size()) + " columns",
                     "22: t_ns and the 21 numbers c00,c01,...,c55");
  }
  TimedCovariance row;
  const auto ns = parse_int64(parts[0]);
  if (!ns) throw InputError(path, line, "time " + in_quotes(parts[0]), "integer nanoseconds");
  row.time.ns = *ns;
  std::size_t k = 1;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j, ++k) {
      const auto value = parse_double(parts[k]);
      if (!value || !std::isfinite(*value))
        throw InputError(path, line, "value " + in_quotes(parts[k]), "a finite number");
      row.P(i, j) = row.P(j, i) = *value;
    }
  }
  return row;
}

}  // namespace

std::vector<TimedCovariance> read_covariances(const std::string& path) {
  std::vector<TimedCovariance> rows;
  int number = 0;
  bool header_seen = false;
  for (const std::string& line : read_lines(path)) {
    ++number;
    const std::string_view text = trimmed(line);
    if (text.empty() || text.front() == '#') continue;
    if (!header_seen) {
      if (text.substr(0, 4) != "t_ns")
        throw InputError(path, number, in_quotes(text), "the header line t_ns,c00,c01,...,c55");
      header_seen = true;
      continue;
    }
    rows.push_back(parse_row(path, number, text));
    if (rows.size() > 1 && rows.back().time <= rows[rows.size() - 2].time) {
      throw InputError(path, number, "time " + std::to_string(rows.back().time.ns) + " repeats or goes back",
                       "strictly increasing times");
    }
  }
  if (rows.empty()) throw InputError(path, 0, "holds no covariance", "a header line and rows t_ns,c00,c01,...,c55");
  return rows;
}

std::string covariance_header() {
  std::string header = "t_ns";
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) header += format_text(",c%d%d", i, j);
  }
  return header;
}

std::string covariance_line(const TimedCovariance& covariance) {
  std::string line = std::to_string(covariance.time.ns);
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) line += format_text(",%.9e", covariance.P(i, j));
  }
  return line;
}

}  // namespace relnav::hil
