#pragma once
#include <yaml-cpp/yaml.h>

#include <initializer_list>
#include <string>
#include <vector>

namespace relnav {

/// Line of a node in its file, from 1.
[[nodiscard]] inline int line_of(const YAML::Node& node) { return node.Mark().line + 1; }

/// Parses a file; OpenCV's directive "%YAML:1.0" is let pass. Throws InputError; `expectation` is what the file should
/// have been.
[[nodiscard]] YAML::Node load_yaml(const std::string& path, const std::string& expectation);

/// A map of a YAML file, with the reading of values and the messages (InputError) when they are not what they should be.
class YamlReader {
 public:
  YamlReader(std::string path, YAML::Node node) : path_(std::move(path)), node_(std::move(node)) {}

  /// The first of the keys that is there; undefined when none is.
  [[nodiscard]] YAML::Node find(std::initializer_list<const char*> keys) const;
  [[nodiscard]] bool has(std::initializer_list<const char*> keys) const { return find(keys).IsDefined(); }
  [[nodiscard]] YAML::Node require(std::initializer_list<const char*> keys, const std::string& expectation) const;

  [[noreturn]] void fail(const YAML::Node& at, const std::string& problem, const std::string& expectation) const;

  /// A finite number.
  [[nodiscard]] double number(const YAML::Node& node, const std::string& what) const;
  /// The numbers of a list, of a list of rows, or of a map with the list `data`.
  [[nodiscard]] std::vector<double> numbers(const YAML::Node& node, const std::string& what) const;

 private:
  std::string path_;
  YAML::Node node_;
};

}  // namespace relnav
