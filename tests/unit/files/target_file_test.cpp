#include "platform/files/target_file.hpp"

#include "tests/support/scratch.hpp"

using namespace relnav;
using relnav::test::message_of;
using relnav::test::replaced;
using relnav::test::Scratch;

namespace {

const std::string square =
    "frame: T\n"                                                // 1
    "features:\n"                                               // 2
    "  - {id: 7, xyz: [-0.5, 0, 0.25]}\n"                       // 3
    "  - {id: 3, xyz: [0, -0.5, 0], normal: [0, 0, -2]}\n"      // 4
    "  - {id: 65535, xyz: [0.5, 0, 0], normal: [3, 0, -4.]}\n"  // 5
    "  - id: 0\n"                                               // 6
    "    xyz: [0, 0.5, 0]\n"                                    // 7
    "lines: [[7, 3], [3, 65535],\n"                             // 8
    "        [65535, 0]]\n";                                    // 9

std::string many_features(std::size_t count) {
  std::string text = "features:\n";
  for (std::size_t i = 0; i < count; ++i) {
    text += "- {id: " + std::to_string(i) + ", xyz: [" + std::to_string(i) + ", " + std::to_string(i * i) + ", 0]}\n";
  }
  return text;
}

// yaml-cpp builds tables at first use and keeps them: let that happen before CppUTest watches for leaks.
const bool yaml_tables_built = [] {
  const Scratch scratch;
  for (const std::string& text : {square, replaced(square, "-0.5", "[x"), replaced(square, "-0.5", ".nan")}) {
    static_cast<void>(message_of([&] { static_cast<void>(read_target_file(scratch.write("t.yaml", text))); }));
  }
  return true;
}();

}  // namespace

TEST_GROUP(TargetFile) {
  Scratch scratch;
  TargetModel read(const std::string& text) { return read_target_file(scratch.write("target.yaml", text)); }
  std::string failure(const std::string& text) {
    return message_of([&] { static_cast<void>(read(text)); });
  }
  std::string failure_with(const std::string& from, const std::string& to) {
    return failure(replaced(square, from, to));
  }
};

TEST(TargetFile, ReadsFeaturesNormalsAndLines) {
  const TargetModel target = read(square);
  CHECK_EQUAL(4U, target.features.size());
  CHECK_EQUAL(7, target.features[0].id);
  CHECK_EQUAL(65535, target.features[2].id);
  DOUBLES_EQUAL(0.0, (target.features[0].p_T - Vec3(-0.5, 0.0, 0.25)).norm(), 1e-15);
  DOUBLES_EQUAL(0.0, (target.features[3].p_T - Vec3(0.0, 0.5, 0.0)).norm(), 1e-15);
  DOUBLES_EQUAL(0.0, target.features[0].normal_T.norm(), 0.0);
  DOUBLES_EQUAL(0.0, (target.features[1].normal_T - Vec3(0.0, 0.0, -1.0)).norm(), 1e-15);
  DOUBLES_EQUAL(0.0, (target.features[2].normal_T - Vec3(0.6, 0.0, -0.8)).norm(), 1e-15);
  CHECK_EQUAL(3U, target.lines.size());
  CHECK_EQUAL(1, target.lines[1].from);  // positions, not ids
  CHECK_EQUAL(2, target.lines[1].to);
  CHECK_EQUAL(3, target.lines[2].to);
}

TEST(TargetFile, ReadsBackWhatIsWritten) {
  const TargetModel target = read(square);
  const std::string text = target_file_text(target);
  const TargetModel again = read(text);
  STRCMP_EQUAL(text.c_str(), target_file_text(again).c_str());
  CHECK_EQUAL(target.features.size(), again.features.size());
  for (std::size_t i = 0; i < target.features.size(); ++i) {
    CHECK(target.features[i].id == again.features[i].id);
    CHECK(target.features[i].p_T == again.features[i].p_T);
    DOUBLES_EQUAL(0.0, (target.features[i].normal_T - again.features[i].normal_T).norm(), 1e-15);
  }
  CHECK_EQUAL(3U, again.lines.size());
  CHECK_EQUAL(2, again.lines[2].from);
}

TEST(TargetFile, UnitsAreMetresOrMillimetres) {
  DOUBLES_EQUAL(-0.5, read(replaced(square, "frame: T", "unit: m")).features[0].p_T.x(), 1e-15);
  DOUBLES_EQUAL(-5e-4, read(replaced(square, "frame: T", "unit: mm")).features[0].p_T.x(), 1e-15);
  DOUBLES_EQUAL(-1.0, read(replaced(square, "frame: T", "unit: mm")).features[1].normal_T.z(), 1e-15);
  CHECK_MESSAGE_HOLDS(failure_with("frame: T", "unit: inch"), "target.yaml:1: unit 'inch' (expected m or mm)");
}

TEST(TargetFile, WhatIsNoTargetFileIsSaid) {
  CHECK_MESSAGE_HOLDS(failure(""), "target.yaml: holds no keys (expected a target model in YAML)");
  CHECK_MESSAGE_HOLDS(failure("- 1\n"), "target.yaml: holds no keys");
  CHECK_MESSAGE_HOLDS(failure("features: [1\nb: 3\n"), "not YAML");
  CHECK_MESSAGE_HOLDS(failure("frame: T\n"), "target.yaml: missing key 'features' (expected features: [{id: 0, xyz");
  CHECK_MESSAGE_HOLDS(failure("frame: T\nfeatures: 3\n"), "target.yaml:2: features is not a list");
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(read_target_file(scratch.path("no.yaml"))); }),
                      "no.yaml: cannot be opened");
}

TEST(TargetFile, DuplicateIdNamesBothLines) {
  CHECK_MESSAGE_HOLDS(failure_with("id: 65535", "id: 7"),
                      "target.yaml:5: id 7 again, first in line 3 (expected an id of its own");
}

TEST(TargetFile, CountsOfFeaturesAndLinesAreBounded) {
  CHECK_MESSAGE_HOLDS(failure(many_features(2)), "target.yaml:2: 2 features (expected at least 3)");
  CHECK_EQUAL(config::max_target_features, read(many_features(config::max_target_features)).features.size());
  CHECK_MESSAGE_HOLDS(failure(many_features(config::max_target_features + 1)),
                      "target.yaml:" + std::to_string(config::max_target_features + 2) +
                          ": too many features (expected at most " + std::to_string(config::max_target_features));
  std::string lines = many_features(3) + "lines:\n";
  for (std::size_t i = 0; i < config::max_target_lines; ++i) lines += "- [0, 1]\n";
  CHECK_EQUAL(config::max_target_lines, read(lines).lines.size());
  CHECK_MESSAGE_HOLDS(failure(lines + "- [0, 1]\n"), "too many lines (expected at most");
}

TEST(TargetFile, CollinearFeaturesAreRefused) {
  const auto three = [](const std::string& x, const std::string& y) {
    return "features:\n- {id: 0, xyz: [1, 1, 1]}\n- {id: 1, xyz: [2, 2, 2]}\n- {id: 2, xyz: [" + x + ", " + y +
           ", 3]}\n";
  };
  CHECK_MESSAGE_HOLDS(failure(three("3", "3")),
                      "target.yaml:2: all 3 features lie on one line (expected at least 3 that do not)");
  CHECK_MESSAGE_HOLDS(failure(three("3", "3.0000001")), "lie on one line");
  CHECK_EQUAL(3U, read(three("3", "3.001")).features.size());
  const std::string same = "- {id: 0, xyz: [1, 1, 1]}\n";
  CHECK_MESSAGE_HOLDS(failure("features:\n" + same + replaced(same, "0", "1") + replaced(same, "0", "2")),
                      "lie on one line");
}

TEST(TargetFile, BadNumbersAreNamedWithTheirLine) {
  CHECK_MESSAGE_HOLDS(failure_with("-0.5, 0, 0.25", "-0.5, 0"),
                      "target.yaml:3: xyz of feature 7 has 2 numbers (expected 3: [x, y, z])");
  CHECK_MESSAGE_HOLDS(failure_with("[0, 0.5, 0]", "0.5"), "target.yaml:7: xyz of feature 0 is not a list");
  CHECK_MESSAGE_HOLDS(failure_with("[0, 0, -2]", "[0, 0, 1, 2]"),
                      "target.yaml:4: normal of feature 3 has 4 numbers (expected 3");
  CHECK_MESSAGE_HOLDS(failure_with("0.25", "x"), "target.yaml:3: xyz of feature 7 is 'x' (expected a finite number)");
  for (const char* bad : {"nan", ".inf", "-inf", ".nan"})
    CHECK_MESSAGE_HOLDS(failure_with("0.25", bad), "not finite (expected a finite number)");
  CHECK_MESSAGE_HOLDS(failure_with("[0, 0, -2]", "[0, 0, 0]"),
                      "target.yaml:4: normal of feature 3 has length zero (expected a direction");
}

TEST(TargetFile, FeaturesNeedAnIdAndAPlace) {
  for (const char* bad : {"-1", "65536", "a", "1.5"})
    CHECK_MESSAGE_HOLDS(failure_with("id: 3", std::string("id: ") + bad),
                        "target.yaml:4: id '" + std::string(bad) + "' (expected a whole number from 0 to 65535)");
  CHECK_MESSAGE_HOLDS(failure_with("id: 3", "id: [3]"), "target.yaml:4: id that is no single value");
  CHECK_MESSAGE_HOLDS(failure_with("{id: 3, ", "{"), "target.yaml:4: a feature without id (expected {id: 0, xyz");
  CHECK_MESSAGE_HOLDS(failure_with("xyz: [0, -0.5, 0], ", ""), "target.yaml:4: no xyz of feature 3 (expected {id");
  CHECK_MESSAGE_HOLDS(failure_with("{id: 7, xyz: [-0.5, 0, 0.25]}", "[7, 0, 0]"),
                      "target.yaml:3: a feature that is no map");
}

TEST(TargetFile, LinesNeedTwoKnownFeatures) {
  CHECK_MESSAGE_HOLDS(failure_with("[65535, 0]", "[65535, 8]"),
                      "target.yaml:9: a line to unknown id '8' (expected ids of two features)");
  CHECK_MESSAGE_HOLDS(failure_with("[65535, 0]", "[3, 3]"), "target.yaml:9: a line from '3' to itself");
  CHECK_MESSAGE_HOLDS(failure_with("[65535, 0]", "[3]"), "target.yaml:9: a line that is no pair (expected lines: [[id");
  CHECK_MESSAGE_HOLDS(failure_with("[65535, 0]", "x"), "target.yaml:9: a line that is no pair");
  CHECK_MESSAGE_HOLDS(failure(many_features(3) + "lines: 4\n"), "target.yaml:5: lines is not a list");
}
