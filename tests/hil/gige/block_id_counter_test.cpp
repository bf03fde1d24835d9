#include "platform/linux/block_id_counter.hpp"

#include <CppUTest/TestHarness.h>  // last: it redefines new

using relnav::platform::linux::BlockIdCounter;

TEST_GROUP(BlockIdCounter){};

TEST(BlockIdCounter, BeginsAtZeroAndCountsWhatIsLost) {
  BlockIdCounter counter;
  CHECK_EQUAL(0, counter.count(1));
  CHECK_EQUAL(1, counter.count(2));
  CHECK_EQUAL(5, counter.count(6));
}

TEST(BlockIdCounter, FramesLostAtTheStartCount) {
  BlockIdCounter counter;
  CHECK_EQUAL(2, counter.count(3));
  CHECK_EQUAL(3, counter.count(4));
}

TEST(BlockIdCounter, ACameraThatCountsOnFromEarlierBeginsAtZero) {
  BlockIdCounter counter;
  CHECK_EQUAL(0, counter.count(65400));
  CHECK_EQUAL(135, counter.count(65535));
  CHECK_EQUAL(136, counter.count(1));  // 0 is no number
  CHECK_EQUAL(138, counter.count(3));
}

TEST(BlockIdCounter, LossesOverTheWrapCount) {
  BlockIdCounter counter;
  CHECK_EQUAL(0, counter.count(65530));
  CHECK_EQUAL(15, counter.count(10));
}

TEST(BlockIdCounter, WideNumbersDoNotWrapAt16Bits) {
  BlockIdCounter counter(0);
  CHECK_EQUAL(0, counter.count(0));
  CHECK_EQUAL(65535, counter.count(65535));
  CHECK_EQUAL(65536, counter.count(65536));
  CHECK_EQUAL(65537, counter.count(65537));
}

TEST(BlockIdCounter, ABeginAnewIsOneFrameLater) {
  BlockIdCounter counter;
  CHECK_EQUAL(0, counter.count(20000));
  CHECK_EQUAL(1, counter.count(1));
  CHECK_EQUAL(2, counter.count(2));
  CHECK_EQUAL(3, counter.count(2));  // a number twice
}

TEST(BlockIdCounter, AFrameWithoutNumberIsTakenForTheNextAndForgotten) {
  BlockIdCounter counter;
  CHECK_EQUAL(0, counter.count(1));
  CHECK_EQUAL(1, counter.count(0));
  CHECK_EQUAL(2, counter.count(3));
}
