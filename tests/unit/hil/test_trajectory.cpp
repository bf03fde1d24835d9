#include "hil/io/trajectory.hpp"

#include "hil/evaluate/rotation.hpp"
#include "hil/io/covariance_csv.hpp"
#include "platform/files/text.hpp"
#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::message_of;
using relnav::test::Scratch;

TEST_GROUP(Seconds){};

TEST(Seconds, ParsesExactNanoseconds) {
  CHECK(parse_seconds_to_ns("100.000000001") == 100000000001);
  CHECK(parse_seconds_to_ns("1403636579.763555527") == 1403636579763555527);  // a double cannot hold this one
  CHECK(parse_seconds_to_ns("1.403636579763555527e+09") == 1403636579763555527);
  CHECK(parse_seconds_to_ns("-0.5") == -500000000);
  CHECK(parse_seconds_to_ns("7") == 7000000000);
  CHECK(parse_seconds_to_ns("0.0000000005") == 1);
  CHECK(parse_seconds_to_ns("0.00000000049") == 0);
  CHECK(parse_seconds_to_ns("1e-300") == 0);
}

TEST(Seconds, RefusesWhatIsNoTime) {
  for (const char* text : {"", ".", "nan", "inf", "1.2.3", "1e", "1ex", "9999999999999", "1e30", "--1"}) {
    CHECK_TEXT(!parse_seconds_to_ns(text), text);
  }
}

TEST(Seconds, WritesNineDecimals) {
  STRCMP_EQUAL("1403636579.763555527", format_seconds(1403636579763555527).c_str());
  STRCMP_EQUAL("-0.000000001", format_seconds(-1).c_str());
  STRCMP_EQUAL("0.000000000", format_seconds(0).c_str());
}

TEST_GROUP(TrajectoryFile) {
  Scratch scratch;
  std::string failure(const std::string& text) {
    const std::string path = scratch.write("t.tum", text);
    return message_of([&] { static_cast<void>(read_trajectory(path)); });
  }
};

TEST(TrajectoryFile, ReadsBackWhatIsWritten) {
  TimedPose pose;
  pose.time.ns = 1403636579763555527;
  pose.t_CT = Vec3(1.25, -2.5, 1e-9);
  pose.R_CT = rotation_exp(Vec3(3.0, 0.4, -0.5));
  const std::string path =
      scratch.write("t.tum", std::string(trajectory_header) + "\n" + trajectory_line(pose) + "  # note\r\n\n");
  const Trajectory read = read_trajectory(path);
  CHECK_EQUAL(1U, read.size());
  CHECK(read[0].time == pose.time);
  DOUBLES_EQUAL(0.0, (read[0].t_CT - pose.t_CT).norm(), 1e-9);
  DOUBLES_EQUAL(0.0, (read[0].R_CT - pose.R_CT).norm(), 1e-11);
}

TEST(TrajectoryFile, WritesQuaternionWithPositiveW) {
  TimedPose pose;
  pose.R_CT = rotation_exp(Vec3(0.0, 0.0, -3.1));
  const std::string line = trajectory_line(pose);
  CHECK_TEXT(line.substr(line.rfind(' ') + 1, 1) != "-", line.c_str());
}

TEST(TrajectoryFile, MessagesNameFileLineAndExpectation) {
  const std::string few = failure("# c\n1 2 3\n");
  CHECK_MESSAGE_HOLDS(few, "t.tum:2: 3 values");
  CHECK_MESSAGE_HOLDS(few, "expected 8 numbers: t tx ty tz qx qy qz qw");
  CHECK_MESSAGE_HOLDS(failure("1 2 3 x 0 0 0 1\n"), "t.tum:1: value 'x' (expected a finite number)");
  CHECK_MESSAGE_HOLDS(failure("1 2 3 nan 0 0 0 1\n"), "t.tum:1: value 'nan'");
  CHECK_MESSAGE_HOLDS(failure("y 2 3 4 0 0 0 1\n"), "t.tum:1: time 'y' (expected decimal seconds)");
  CHECK_MESSAGE_HOLDS(failure("1 2 3 4 0 0 0 2\n"), "t.tum:1: quaternion of length 2");
  CHECK_MESSAGE_HOLDS(failure("1 2 3 4 0 0 0 0\n"), "unit quaternion");
  CHECK_MESSAGE_HOLDS(failure("2 0 0 1 0 0 0 1\n2 0 0 1 0 0 0 1\n"), "t.tum:2: time 2.000000000 after 2.000000000");
  CHECK_MESSAGE_HOLDS(failure("2 0 0 1 0 0 0 1\n1 0 0 1 0 0 0 1\n"), "strictly increasing");
  CHECK_MESSAGE_HOLDS(failure("# nothing\n"), "holds no pose");
  CHECK_MESSAGE_HOLDS(failure(""), "holds no pose");
}

TEST(TrajectoryFile, MissingFileAndFolderAreNamed) {
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(read_trajectory(scratch.path("none.tum"))); }),
                      "none.tum: cannot be opened");
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(read_trajectory(scratch.path(""))); }), "is a folder");
}

TEST_GROUP(CovarianceFile) {
  Scratch scratch;
  std::string failure(const std::string& text) {
    const std::string path = scratch.write("c.csv", text);
    return message_of([&] { static_cast<void>(read_covariances(path)); });
  }
};

TEST(CovarianceFile, ReadsBackWhatIsWritten) {
  TimedCovariance row;
  row.time.ns = 100000000001;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) row.P(i, j) = row.P(j, i) = 1e-6 * (10 * i + j) - 3e-6;
  }
  STRCMP_EQUAL("t_ns,c00,c01,c02,c03,c04,c05,c11,c12,c13,c14,c15,c22,c23,c24,c25,c33,c34,c35,c44,c45,c55",
               covariance_header().c_str());
  const auto read = read_covariances(scratch.write("c.csv", covariance_header() + "\n" + covariance_line(row) + "\n"));
  CHECK_EQUAL(1U, read.size());
  CHECK(read[0].time == row.time);
  DOUBLES_EQUAL(0.0, (read[0].P - row.P).norm(), 1e-13);
}

TEST(CovarianceFile, MessagesNameFileLineAndExpectation) {
  const std::string header = covariance_header() + "\n";
  CHECK_MESSAGE_HOLDS(failure(header + "1,2,3\n"), "c.csv:2: 3 columns (expected 22: t_ns and the 21 numbers");
  std::string bad = covariance_line({});
  bad.replace(bad.rfind(','), std::string::npos, ",inf");
  CHECK_MESSAGE_HOLDS(failure(header + bad + "\n"), "c.csv:2: value 'inf' (expected a finite number)");
  CHECK_MESSAGE_HOLDS(failure("1,2,3\n"), "c.csv:1: '1,2,3' (expected the header line");
  CHECK_MESSAGE_HOLDS(failure(header), "holds no covariance");
  const std::string row = covariance_line({}) + "\n";
  CHECK_MESSAGE_HOLDS(failure(header + row + row), "c.csv:3: time 0 repeats or goes back");
}
