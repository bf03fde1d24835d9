#pragma once
#include <yaml-cpp/yaml.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "fsw/math/types.hpp"
#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"
#include "platform/files/yaml_reader.hpp"

namespace relnav {

/// What words a key takes, and what each means.
template <typename Value, std::size_t count>
using Words = std::array<std::pair<const char*, Value>, count>;

/// A section of the file: a map in which every key is known.
class FileSection {
 public:
  FileSection(const std::string& path, const YAML::Node& node, std::string name, std::vector<std::string> keys)
      : path_(path), node_(node), name_(std::move(name)), keys_(std::move(keys)) {
    if (!node_.IsMap()) fail(node_, in_quotes(name_) + " holds no keys", "keys of " + list_of_keys());
    std::set<std::string> given;
    for (const auto& entry : node_) {
      const std::string key = entry.first.Scalar();
      if (!given.insert(key).second)
        fail(entry.first, "key " + in_quotes(full_name(key)) + " a second time", "it once");
      bool known = false;
      for (const std::string& k : keys_) known = known || k == key;
      if (!known) fail(entry.first, "unknown key " + in_quotes(full_name(key)), "one of " + list_of_keys());
    }
  }

  [[nodiscard]] YAML::Node node(const char* key) const {
    const YAML::Node map = node_;  // of a constant one an unknown key does not become part
    return map[key];
  }
  [[nodiscard]] bool has(const char* key) const { return static_cast<bool>(node(key)); }
  [[nodiscard]] YAML::Node require(const char* key, const std::string& expectation) const {
    YAML::Node value = node(key);
    if (!value) fail(node_, "missing key " + in_quotes(full_name(key)), expectation);
    return value;
  }

  [[nodiscard]] std::string text(const char* key, const std::string& expectation) const {
    const YAML::Node value = require(key, expectation);
    if (!value.IsScalar() || value.Scalar().empty()) fail(value, full_name(key) + " is no text", expectation);
    return value.Scalar();
  }
  [[nodiscard]] std::string text_or(const char* key, const std::string& fallback) const {
    return has(key) ? text(key, "a text") : fallback;
  }
  /// A path, relative to the file.
  [[nodiscard]] std::string file(const char* key, const std::string& expectation) const {
    return (std::filesystem::path(path_).parent_path() / text(key, expectation)).string();
  }
  [[nodiscard]] double number_or(const char* key, double low, double high, double fallback) const {
    if (!has(key)) return fallback;
    const YAML::Node value = node(key);
    const auto number = value.IsScalar() ? parse_double(value.Scalar()) : std::nullopt;
    if (!number || !std::isfinite(*number) || *number < low || *number > high) {
      fail(value, full_name(key) + " is " + in_quotes(value.IsScalar() ? value.Scalar() : "a list or map"),
           format_text("a number from %g to %g", low, high));
    }
    return *number;
  }
  [[nodiscard]] std::int64_t whole_or(const char* key, std::int64_t low, std::int64_t high,
                                      std::int64_t fallback) const {
    if (!has(key)) return fallback;
    const YAML::Node value = node(key);
    const auto number = value.IsScalar() ? parse_int64(value.Scalar()) : std::nullopt;
    if (!number || *number < low || *number > high) {
      fail(value, full_name(key) + " is " + in_quotes(value.IsScalar() ? value.Scalar() : "a list or map"),
           "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    }
    return *number;
  }
  template <typename Value, std::size_t count>
  [[nodiscard]] Value word(const char* key, const Words<Value, count>& words) const {
    std::string names;
    for (const auto& [name, value] : words) names += (names.empty() ? "" : ", ") + std::string(name);
    const std::string given = text(key, "one of " + names);
    for (const auto& [name, value] : words) {
      if (given == name) return value;
    }
    fail(node(key), full_name(key) + " is " + in_quotes(given), "one of " + names);
  }
  template <typename Value, std::size_t count>
  [[nodiscard]] Value word_or(const char* key, const Words<Value, count>& words, Value fallback) const {
    return has(key) ? word(key, words) : fallback;
  }

  /// A list of finite numbers.
  [[nodiscard]] std::vector<double> numbers(const char* key, const std::string& expectation) const {
    const YAML::Node value = require(key, expectation);
    if (!value.IsSequence()) fail(value, full_name(key) + " is no list", expectation);
    return YamlReader(path_, node_).numbers(value, full_name(key));
  }
  /// Three of them, none larger than `most` in size.
  [[nodiscard]] Vec3 three(const char* key, double most) const {
    const std::string expectation = format_text("three numbers from %g to %g", -most, most);
    const std::vector<double> list = numbers(key, expectation);
    if (list.size() != 3)
      fail(node(key), full_name(key) + ": " + std::to_string(list.size()) + " numbers", expectation);
    for (const double value : list) {
      if (std::abs(value) > most) fail(node(key), full_name(key) + format_text(" holds %g", value), expectation);
    }
    return {list[0], list[1], list[2]};
  }
  [[nodiscard]] Vec3 three_or(const char* key, double most, const Vec3& fallback) const {
    return has(key) ? three(key, most) : fallback;
  }
  [[nodiscard]] bool yes_no_or(const char* key, bool fallback) const {
    constexpr Words<bool, 2> words{{{"true", true}, {"false", false}}};
    return word_or(key, words, fallback);
  }
  /// A section within, at a key or at a node below it.
  [[nodiscard]] FileSection section(const char* key, std::vector<std::string> keys) const {
    return section(node(key), key, std::move(keys));
  }
  [[nodiscard]] FileSection section(const YAML::Node& at, const std::string& key, std::vector<std::string> keys) const {
    return {path_, at, full_name(key), std::move(keys)};
  }
  [[nodiscard]] const YAML::Node& map() const { return node_; }

  [[noreturn]] void fail(const YAML::Node& at, const std::string& problem, const std::string& expectation) const {
    throw InputError(path_, line_of(at), problem, expectation);
  }

 private:
  [[nodiscard]] std::string full_name(const std::string& key) const { return name_.empty() ? key : name_ + "." + key; }
  [[nodiscard]] std::string list_of_keys() const {
    std::string list;
    for (const std::string& key : keys_) list += (list.empty() ? "" : ", ") + key;
    return list;
  }

  std::string path_;
  YAML::Node node_;
  std::string name_;
  std::vector<std::string> keys_;
};

}  // namespace relnav
