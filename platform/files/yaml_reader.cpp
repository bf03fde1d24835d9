#include "platform/files/yaml_reader.hpp"

#include <cmath>

#include "platform/files/input_error.hpp"
#include "platform/files/text.hpp"

namespace relnav {
namespace {

std::string preprocess(std::string text) {
  // OpenCV's directive "%YAML:1.0" is not YAML; blank it out and keep the line count.
  if (text.rfind("%YAML", 0) == 0) {
    for (std::size_t i = 0; i < text.size() && text[i] != '\n'; ++i) text[i] = ' ';
  }
  return text;
}

// Where the numbers of a matrix stand: `data` of a map, or the node itself.
YAML::Node list_of(const YAML::Node& node) { return node.IsMap() ? node["data"] : node; }

}  // namespace

YAML::Node load_yaml(const std::string& path, const std::string& expectation) {
  try {
    return YAML::Load(preprocess(read_text(path)));
  } catch (const YAML::ParserException& error) {
    throw InputError(path, error.mark.line + 1, "not YAML: " + error.msg, expectation);
  }
}

YAML::Node YamlReader::find(std::initializer_list<const char*> keys) const {
  for (const char* key : keys) {
    if (const YAML::Node value = node_[key]; value) return value;
  }
  return YAML::Node(YAML::NodeType::Undefined);
}

YAML::Node YamlReader::require(std::initializer_list<const char*> keys, const std::string& expectation) const {
  YAML::Node value = find(keys);
  if (!value) throw InputError(path_, 0, std::string("missing key '") + *keys.begin() + "'", expectation);
  return value;
}

void YamlReader::fail(const YAML::Node& at, const std::string& problem, const std::string& expectation) const {
  const YAML::Node list = list_of(at);
  throw InputError(path_, line_of(list ? list : at), problem, expectation);
}

double YamlReader::number(const YAML::Node& node, const std::string& what) const {
  if (!node.IsScalar()) fail(node, what + " is not a number", "a finite number");
  std::string_view text = node.Scalar();
  if (text.size() > 1 && text.back() == '.') text.remove_suffix(1);  // OpenCV writes "1."
  const auto value = parse_double(text);
  if (value && std::isfinite(*value)) return *value;
  const bool not_finite = value.has_value() || text == ".nan" || text == ".NaN" || text == ".Nan" || text == ".NAN" ||
                          text.find(".inf") != text.npos || text.find(".Inf") != text.npos;
  fail(node, what + " is " + in_quotes(node.Scalar()) + (not_finite ? ", not finite" : ""), "a finite number");
}

std::vector<double> YamlReader::numbers(const YAML::Node& node, const std::string& what) const {
  std::vector<double> values;
  const YAML::Node list = list_of(node);
  if (!list || !list.IsSequence()) fail(node, what + " is not a list", "a list of numbers");
  for (const auto& item : list) {
    if (item.IsSequence()) {  // Kalibr writes matrices as a list of rows
      for (const auto& inner : item) values.push_back(number(inner, what));
    } else {
      values.push_back(number(item, what));
    }
  }
  return values;
}

}  // namespace relnav
