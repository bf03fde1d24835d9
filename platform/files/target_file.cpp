#include "platform/files/target_file.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string_view>

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"
#include "platform/files/yaml_reader.hpp"

namespace relnav {
namespace {

constexpr const char* feature_expectation = "features: [{id: 0, xyz: [x, y, z]}, ...]";
constexpr std::size_t least_features = 3;
/// Features further off their common line than this part of their extent are not collinear.
constexpr double collinear_tolerance = 1e-6;

struct Known {
  std::uint16_t position = 0;  // in the model
  int line = 0;                // in the file
};
using Ids = std::map<std::uint16_t, Known>;

double metres_per_unit(const YamlReader& file) {
  const YAML::Node at = file.find({"unit"});
  if (!at) return 1.0;
  const std::string unit = at.IsScalar() ? at.Scalar() : "";
  if (unit == "m") return 1.0;
  if (unit == "mm") return 1e-3;
  file.fail(at, "unit " + in_quotes(unit), "m or mm");
}

std::uint16_t id_of(const YamlReader& file, const YAML::Node& at) {
  const auto value = at.IsScalar() ? parse_int64(at.Scalar()) : std::nullopt;
  if (!value || *value < 0 || *value > UINT16_MAX)
    file.fail(at, "id " + (at.IsScalar() ? in_quotes(at.Scalar()) : "that is no single value"),
              "a whole number from 0 to 65535");
  return static_cast<std::uint16_t>(*value);
}

Vec3 vector_of(const YamlReader& file, const YAML::Node& at, const std::string& what) {
  const auto values = file.numbers(at, what);
  if (values.size() != 3) file.fail(at, what + " has " + std::to_string(values.size()) + " numbers", "3: [x, y, z]");
  return {values[0], values[1], values[2]};
}

TargetFeature feature_of(const YamlReader& file, const YAML::Node& item, double scale) {
  if (!item.IsMap()) file.fail(item, "a feature that is no map", "{id: 0, xyz: [x, y, z]}");
  TargetFeature feature;
  const YAML::Node id = item["id"];
  if (!id) file.fail(item, "a feature without id", "{id: 0, xyz: [x, y, z]}");
  feature.id = id_of(file, id);
  const std::string name = " of feature " + std::to_string(feature.id);
  const YAML::Node xyz = item["xyz"];
  if (!xyz) file.fail(item, "no xyz" + name, "{id: 0, xyz: [x, y, z]}");
  feature.p_T = scale * vector_of(file, xyz, "xyz" + name);
  if (const YAML::Node normal = item["normal"]; normal) {
    const Vec3 n = vector_of(file, normal, "normal" + name);
    const double length = n.stableNorm();
    if (!(length > 0.0)) file.fail(normal, "normal" + name + " has length zero", "a direction [nx, ny, nz]");
    feature.normal_T = n / length;
  }
  return feature;
}

bool collinear(const TargetModel& target) {
  const Vec3 origin = target.features[0].p_T;
  Vec3 farthest = Vec3::Zero();
  for (const TargetFeature& f : target.features) {
    if ((f.p_T - origin).norm() > farthest.norm()) farthest = f.p_T - origin;
  }
  const double extent = farthest.norm();
  return std::all_of(target.features.begin(), target.features.end(), [&](const TargetFeature& f) {
    return (f.p_T - origin).cross(farthest).norm() <= collinear_tolerance * extent * extent;
  });
}

Ids read_features(const YamlReader& file, TargetModel& target) {
  const YAML::Node list = file.require({"features"}, feature_expectation);
  if (!list.IsSequence()) file.fail(list, "features is not a list", feature_expectation);
  const double scale = metres_per_unit(file);
  Ids ids;
  for (const auto& item : list) {
    const TargetFeature feature = feature_of(file, item, scale);
    const auto position = static_cast<std::uint16_t>(target.features.size());
    const auto [known, fresh] = ids.insert({feature.id, {position, line_of(item)}});
    if (!fresh)
      file.fail(item,
                "id " + std::to_string(feature.id) + " again, first in line " + std::to_string(known->second.line),
                "an id of its own for each feature");
    if (target.features.push_back(feature) != Status::ok)
      file.fail(item, "too many features", "at most " + std::to_string(config::max_target_features));
  }
  const std::string count = std::to_string(target.features.size()) + " features";
  if (target.features.size() < least_features) file.fail(list, count, "at least 3");
  if (collinear(target)) file.fail(list, "all " + count + " lie on one line", "at least 3 that do not");
  return ids;
}

void read_lines_of(const YamlReader& file, const Ids& ids, TargetModel& target) {
  const YAML::Node list = file.find({"lines"});
  if (!list || list.IsNull()) return;
  constexpr const char* expectation = "lines: [[id, id], ...]";
  if (!list.IsSequence()) file.fail(list, "lines is not a list", expectation);
  const auto position_of = [&](const YAML::Node& at) {
    const auto known = ids.find(id_of(file, at));
    if (known == ids.end()) file.fail(at, "a line to unknown id " + in_quotes(at.Scalar()), "ids of two features");
    return known->second.position;
  };
  for (const auto& item : list) {
    if (!item.IsSequence() || item.size() != 2) file.fail(item, "a line that is no pair", expectation);
    const TargetLine line{position_of(item[0]), position_of(item[1])};
    if (line.from == line.to)
      file.fail(item, "a line from " + in_quotes(item[0].Scalar()) + " to itself", "ids of two features");
    if (target.lines.push_back(line) != Status::ok)
      file.fail(item, "too many lines", "at most " + std::to_string(config::max_target_lines));
  }
}

std::string vector_text(const Vec3& v) { return format_text("[%.17g, %.17g, %.17g]", v.x(), v.y(), v.z()); }

}  // namespace

TargetModel read_target_file(const std::string& path) {
  const YAML::Node root = load_yaml(path, "a target model in YAML");
  if (!root.IsMap()) throw InputError(path, 0, "holds no keys", "a target model in YAML");
  const YamlReader file(path, root);
  TargetModel target;
  const Ids ids = read_features(file, target);
  read_lines_of(file, ids, target);
  return target;
}

std::string target_file_text(const TargetModel& target) {
  std::string text = "frame: T\nunit: m\nfeatures:\n";
  for (const TargetFeature& f : target.features) {
    text += "  - {id: " + std::to_string(f.id) + ", xyz: " + vector_text(f.p_T);
    if (f.normal_T.squaredNorm() > 0.0) text += ", normal: " + vector_text(f.normal_T);
    text += "}\n";
  }
  if (!target.lines.empty()) text += "lines:\n";
  for (const TargetLine& line : target.lines) {
    text += "  - [" + std::to_string(target.features[line.from].id) + ", " +
            std::to_string(target.features[line.to].id) + "]\n";
  }
  return text;
}

}  // namespace relnav
