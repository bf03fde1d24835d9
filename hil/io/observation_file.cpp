#include "hil/io/observation_file.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav::hil {
namespace {

enum Column : std::size_t { t_ns, cam, feature_id, u, v, sigma, column_count };
constexpr std::array<std::string_view, column_count> column_names{"t_ns", "cam", "feature_id", "u", "v", "sigma"};
constexpr const char* header_expectation = "the header line t_ns,cam,feature_id,u,v and optionally sigma";
constexpr int largest_camera = 255;

/// Where each column stands in a row.
class Layout {
 public:
  Layout(const std::string& path, int line, std::string_view header) {
    const auto names = split(header, ',');
    for (std::size_t i = 0; i < names.size(); ++i) {
      std::size_t column = 0;
      while (column < column_count && column_names[column] != names[i]) ++column;
      if (column == column_count)
        throw InputError(path, line, in_quotes(names[i]) + " is no column", header_expectation);
      if (place_[column]) throw InputError(path, line, "column " + in_quotes(names[i]) + " twice", header_expectation);
      place_[column] = i;
    }
    for (std::size_t column = 0; column < sigma; ++column) {
      if (!place_[column])
        throw InputError(path, line, "no column " + in_quotes(column_names[column]), header_expectation);
    }
    size_ = names.size();
  }

  [[nodiscard]] bool has(Column column) const { return place_[column].has_value(); }
  [[nodiscard]] std::size_t place(Column column) const { return *place_[column]; }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::array<std::optional<std::size_t>, column_count> place_{};
  std::size_t size_ = 0;
};

/// The values of one row.
class Fields {
 public:
  Fields(const std::string& path, int line, const Layout& layout, std::string_view text)
      : path_(path), line_(line), layout_(layout), parts_(split(text, ',')) {
    if (parts_.size() != layout.size())
      throw InputError(path, line, std::to_string(parts_.size()) + (parts_.size() == 1 ? " column" : " columns"),
                       std::to_string(layout.size()) + " as in the header");
  }

  [[nodiscard]] std::int64_t whole(Column column, std::int64_t low, std::int64_t high,
                                   const std::string& expectation) const {
    const auto value = parse_int64(text(column));
    if (!value || *value < low || *value > high) fail(column, expectation);
    return *value;
  }
  [[nodiscard]] double real(Column column) const {
    const auto value = parse_double(text(column));
    if (!value || !std::isfinite(*value)) fail(column, "a finite number");
    return *value;
  }
  [[noreturn]] void fail(Column column, const std::string& expectation) const {
    throw InputError(path_, line_, std::string(column_names[column]) + " is " + in_quotes(text(column)), expectation);
  }

 private:
  [[nodiscard]] std::string_view text(Column column) const { return parts_[layout_.place(column)]; }

  const std::string& path_;
  int line_;
  const Layout& layout_;
  std::vector<std::string_view> parts_;
};

ObservationRow row_of(const Fields& fields, bool has_sigma, double default_sigma_px, int line) {
  ObservationRow row;
  row.cam = static_cast<int>(fields.whole(cam, 0, largest_camera, "a camera number from 0"));
  row.feature_id =
      static_cast<std::uint16_t>(fields.whole(feature_id, 0, UINT16_MAX, "a whole number from 0 to 65535"));
  row.uv_px = Vec2(fields.real(u), fields.real(v));
  row.sigma_px = has_sigma ? fields.real(sigma) : default_sigma_px;
  if (has_sigma && !(row.sigma_px > 0.0)) fields.fail(sigma, "a positive number of pixels");
  row.line = line;
  return row;
}

void append(const std::string& path, Time time, const ObservationRow& row, std::vector<ObservationEpoch>& epochs) {
  if (epochs.empty() || time > epochs.back().time) epochs.push_back({time, {}});
  ObservationEpoch& epoch = epochs.back();
  if (time < epoch.time)
    throw InputError(path, row.line, "time " + std::to_string(time.ns) + " after " + std::to_string(epoch.time.ns),
                     "rows sorted by time");
  for (const ObservationRow& other : epoch.rows) {
    if (other.cam == row.cam && other.feature_id == row.feature_id)
      throw InputError(path, row.line,
                       "feature " + std::to_string(row.feature_id) + " again in camera " + std::to_string(row.cam) +
                           ", first in line " + std::to_string(other.line),
                       "each feature once a camera and epoch");
  }
  epoch.rows.push_back(row);
}

std::optional<std::uint16_t> position_of(std::uint16_t id, const TargetModel& target) {
  for (std::size_t i = 0; i < target.features.size(); ++i) {
    if (target.features[i].id == id) return static_cast<std::uint16_t>(i);
  }
  return std::nullopt;
}

}  // namespace

std::vector<ObservationEpoch> read_observations(const std::string& path, double default_sigma_px) {
  std::vector<ObservationEpoch> epochs;
  std::optional<Layout> layout;
  int number = 0;
  for (const std::string& line : read_lines(path)) {
    ++number;
    const std::string_view text = trimmed(std::string_view(line).substr(0, line.find('#')));
    if (text.empty()) continue;
    if (!layout) {
      layout.emplace(path, number, text);
      continue;
    }
    const Fields fields(path, number, *layout, text);
    const Time time{fields.whole(t_ns, INT64_MIN, INT64_MAX, "integer nanoseconds")};
    append(path, time, row_of(fields, layout->has(sigma), default_sigma_px, number), epochs);
  }
  if (!layout) throw InputError(path, 0, "is empty", header_expectation);
  if (epochs.empty()) throw InputError(path, 0, "holds no observation", "rows below the header line");
  return epochs;
}

PoseObservations pose_observations(const std::string& path, const ObservationEpoch& epoch, const TargetModel& target,
                                   const CameraRig& rig) {
  PoseObservations result;
  for (const ObservationRow& row : epoch.rows) {
    const auto feature = position_of(row.feature_id, target);
    if (!feature)
      throw InputError(path, row.line, "feature " + std::to_string(row.feature_id) + " is not in the target model",
                       "ids of the target file");
    const auto camera = static_cast<std::size_t>(row.cam);
    if (camera >= rig.size())
      throw InputError(
          path, row.line, "camera " + std::to_string(row.cam) + " has no camera file",
          rig.size() == 1 ? "cam 0, or another --camera" : "cam from 0 to " + std::to_string(rig.size() - 1));
    const CameraModel& model = rig[camera].model;
    if (!model.in_image(row.uv_px))
      throw InputError(
          path, row.line,
          format_text("pixel (%g, %g) is outside of camera %d's image", row.uv_px.x(), row.uv_px.y(), row.cam),
          format_text("a pixel of %d x %d", model.intrinsics().width_px, model.intrinsics().height_px));
    const PoseObservation observation{*feature, static_cast<std::uint16_t>(camera), row.uv_px, row.sigma_px};
    if (result.push_back(observation) != Status::ok)
      throw InputError(path, row.line, "too many rows in one epoch",
                       "at most " + std::to_string(config::max_observations));
  }
  return result;
}

void check_observations(const std::string& path, const std::vector<ObservationEpoch>& epochs, const TargetModel& target,
                        const CameraRig& rig) {
  std::vector<bool> seen(rig.size(), false);
  for (const ObservationEpoch& epoch : epochs) {
    for (const PoseObservation& o : pose_observations(path, epoch, target, rig)) seen[o.camera] = true;
  }
  for (std::size_t camera = 0; camera < seen.size(); ++camera) {
    if (!seen[camera])
      throw InputError(path, 0, "no row of camera " + std::to_string(camera) + ", which has a camera file",
                       "rows of every camera");
  }
}

std::string observation_line(Time time, const ObservationRow& row) {
  return format_text("%lld,%d,%u,%.6f,%.6f,%.6g", static_cast<long long>(time.ns), row.cam,
                     static_cast<unsigned>(row.feature_id), row.uv_px.x(), row.uv_px.y(), row.sigma_px);
}

}  // namespace relnav::hil
