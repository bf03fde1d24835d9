#include "hil/io/euroc.hpp"

#include "tests/support/scratch.hpp"

using namespace relnav;
using namespace relnav::hil;
using relnav::test::message_of;
using relnav::test::Scratch;

TEST_GROUP(ImageList) {
  Scratch scratch;
  std::string failure(const std::string& text) {
    scratch.write("cam0/data.csv", text);
    return message_of([&] { static_cast<void>(read_image_list(scratch.path("cam0"))); });
  }
};

TEST(ImageList, KeepsFileOrderWithRepeatedAndBackwardStamps) {
  scratch.write("cam0/data.csv", "#timestamp [ns],filename\r\n200,a.png\r\n200, b.png \r\n\r\n100,c.png\r\n");
  const auto list = read_image_list(scratch.path("cam0"));
  CHECK_EQUAL(3U, list.size());
  CHECK_EQUAL(200, list[0].time.ns);
  CHECK_EQUAL(200, list[1].time.ns);
  CHECK_EQUAL(100, list[2].time.ns);
  CHECK_EQUAL(5, list[2].line);
  STRCMP_EQUAL(scratch.path("cam0/data/b.png").c_str(), list[1].path.c_str());
}

TEST(ImageList, MessagesNameFileLineAndExpectation) {
  CHECK_MESSAGE_HOLDS(failure("#t,f\n1;a.png\n"),
                      "cam0/data.csv:2: 1 column (expected 2: timestamp in ns and file name)");
  CHECK_MESSAGE_HOLDS(failure("1,a.png\n2,b.png,c\n"), "cam0/data.csv:2: 3 columns");
  CHECK_MESSAGE_HOLDS(failure("1.5,a.png\n"),
                      "cam0/data.csv:1: timestamp '1.5' (expected non-negative integer nanoseconds)");
  CHECK_MESSAGE_HOLDS(failure("99999999999999999999,a.png\n"), "timestamp '99999999999999999999'");
  CHECK_MESSAGE_HOLDS(failure("-1,a.png\n"), "timestamp '-1'");
  CHECK_MESSAGE_HOLDS(failure("1,\n"), "cam0/data.csv:1: empty file name");
  CHECK_MESSAGE_HOLDS(failure("#timestamp [ns],filename\n"),
                      "cam0/data.csv: lists no image (expected at least one row");
  CHECK_MESSAGE_HOLDS(failure(""), "lists no image");
}

TEST(ImageList, MissingFileIsNamed) {
  CHECK_MESSAGE_HOLDS(message_of([&] { static_cast<void>(read_image_list(scratch.path("nowhere"))); }),
                      "nowhere/data.csv: cannot be opened");
}
