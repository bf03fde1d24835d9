#include "hil/simulation/dispersions.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "fsw/base/crc32.hpp"
#include "hil/scenarios/gaussian.hpp"
#include "platform/files/file_section.hpp"

namespace relnav::hil {
namespace {

std::uint64_t stream_of(std::uint64_t seed, const std::string& name) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(name.data());
  return seed ^ (0x9E3779B97F4A7C15ULL * (1ULL + crc32({bytes, name.size()})));
}

/// A camera's fault around its frame, the number in it: `torn@` 20 `:3`.
struct SplitFault {
  std::string before;
  double frame;
  std::string after;
};
std::optional<SplitFault> split_fault(const std::string& text) {
  const std::size_t at = text.find('@') + 1;
  if (at == 0) return std::nullopt;
  const std::size_t end = std::min(text.find(':', at), text.size());
  const auto frame = parse_double(text.substr(at, end - at));
  if (!frame || !std::isfinite(*frame)) return std::nullopt;
  return SplitFault{text.substr(0, at), *frame, text.substr(end)};
}

/// One law of section `dispersions`, at work on the numbers it names.
class Disperser {
 public:
  Disperser(const std::string& path, const YAML::Node& law, std::string name, std::uint64_t seed,
            std::map<std::string, double>& drawn)
      : section_(path, law, "dispersions." + name, {"normal", "uniform", "factor", "choice", "probability"}),
        law_(law),
        path_(path),
        name_(std::move(name)),
        seed_(seed),
        drawn_(drawn) {
    int kinds = 0;
    for (const char* key : {"normal", "uniform", "factor", "choice"}) kinds += section_.has(key) ? 1 : 0;
    if (kinds != 1)
      section_.fail(law, "dispersions." + name_ + " has " + std::to_string(kinds) + " laws",
                    "one of normal, uniform, factor, choice");
  }

  /// `node` is what the path has led to so far.
  void apply(YAML::Node node, const std::string& name) {
    if (node.IsSequence()) {
      for (std::size_t i = 0; i < node.size(); ++i) apply(node[i], name + "." + std::to_string(i));
      return;
    }
    if (!node.IsScalar()) section_.fail(law_, in_quotes(name) + " is a section", "a number or a list of numbers");
    Gaussian random(stream_of(seed_, name));
    const bool applies = random.uniform(0.0, 1.0) < section_.number_or("probability", 0.0, 1.0, 1.0);
    if (section_.has("choice")) {
      const YAML::Node list = section_.node("choice");
      if (!list.IsSequence() || list.size() == 0) section_.fail(law_, "choice is no list", "a list of values");
      const auto index = static_cast<std::size_t>(random.uniform(0.0, 1.0) * static_cast<double>(list.size()));
      if (!applies) return;
      const std::size_t k = std::min(index, list.size() - 1);
      const auto text = list[k].as<std::string>();
      set(node, name, text, parse_double(text).value_or(static_cast<double>(k)));
      return;
    }
    const std::string& text = node.Scalar();
    if (const auto fault = split_fault(text)) {
      const double frame = std::max(0.0, std::round(draw(fault->frame, random)));
      if (applies) set(node, name, fault->before + format_text("%.0f", frame) + fault->after, frame);
      return;
    }
    const auto old = parse_double(text);
    if (!old || !std::isfinite(*old))
      throw InputError(path_, line_of(node), in_quotes(name) + " is " + in_quotes(text),
                       "a number, because dispersions name it");
    const double value = draw(*old, random);
    if (applies) set(node, name, format_text("%.17g", value), value);
  }

 private:
  double draw(double value, Gaussian& random) const {
    constexpr double most = 1e12;
    if (section_.has("normal")) return value + section_.number_or("normal", 0.0, most, 0.0) * random.next();
    if (section_.has("uniform")) {
      const double half_width = section_.number_or("uniform", 0.0, most, 0.0);
      return value + random.uniform(-half_width, half_width);
    }
    constexpr double largest_factor_sigma = 5.0;
    return value * std::exp(section_.number_or("factor", 0.0, largest_factor_sigma, 0.0) * random.next());
  }
  void set(YAML::Node& node, const std::string& name, const std::string& text, double drawn) {
    node = text;  // keeps its place in the file
    drawn_[name] = drawn;
  }

  FileSection section_;
  YAML::Node law_;
  std::string path_;
  std::string name_;
  std::uint64_t seed_;
  std::map<std::string, double>& drawn_;
};

/// The node that a dotted name leads to; missing sections are made, and a missing last key, with 0.
YAML::Node find_named(const std::string& path, YAML::Node root, const YAML::Node& at, const std::string& name) {
  YAML::Node node = root;
  const auto parts = split(name, '.');
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::string key(parts[i]);
    YAML::Node next;
    if (node.IsSequence()) {
      const auto index = parse_int64(key);
      if (!index || *index < 0 || static_cast<std::size_t>(*index) >= node.size())
        throw InputError(path, line_of(at), "dispersions." + name + " names no element of the list",
                         "its number, from 0");
      next = node[static_cast<std::size_t>(*index)];
    } else if (node.IsMap()) {
      const bool last = i + 1 == parts.size();
      if (!node[key] && last) node[key] = "0";
      if (!node[key] && !last) node[key] = YAML::Node(YAML::NodeType::Map);
      next = node[key];
    }
    if (!next || !next.IsDefined())
      throw InputError(path, line_of(at), "dispersions." + name + " names nothing in this file",
                       "the path of a number, such as motion.target.rate_deg_s");
    node.reset(next);
  }
  return node;
}

}  // namespace

std::map<std::string, double> disperse(const std::string& path, YAML::Node& root, std::uint64_t seed) {
  std::map<std::string, double> drawn;
  const YAML::Node laws = root["dispersions"];
  if (!laws) return drawn;
  if (!laws.IsMap())
    throw InputError(path, line_of(laws), "dispersions is no map", "the path of a number and a law for each");
  for (const auto& entry : laws) {
    const std::string name = entry.first.Scalar();
    Disperser law(path, entry.second, name, seed, drawn);
    law.apply(find_named(path, root, entry.first, name), name);
  }
  return drawn;
}

}  // namespace relnav::hil
