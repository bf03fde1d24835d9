#pragma once
// What the test against OpenCV's corners and the program that wrote them down share. Integers only: the same everywhere.
#include <array>
#include <cstddef>
#include <cstdint>

namespace relnav::vision::test {

struct FastSize {
  int width;
  int height;
  int slack;
};

inline constexpr std::array<FastSize, 12> fast_sizes{{{7, 7, 0},
                                                      {8, 30, 3},
                                                      {21, 21, 0},
                                                      {22, 40, 5},
                                                      {23, 23, 1},
                                                      {37, 41, 0},
                                                      {64, 48, 16},
                                                      {101, 67, 11},
                                                      {255, 33, 0},
                                                      {320, 240, 0},
                                                      {641, 479, 7},
                                                      {1024, 40, 0}}};
inline constexpr std::array<int, 8> fast_thresholds{0, 1, 5, 20, 60, 150, 254, 255};

/// Corners of an image at a threshold, with and without suppression, row by row: how many, and FNV-1a over what they are.
struct FastReference {
  std::size_t count = 0;
  std::uint64_t hash = 0xCBF29CE484222325ULL;

  void add_number(long value) {
    for (int byte = 0; byte < 4; ++byte) {
      hash = (hash ^ ((static_cast<std::uint64_t>(value) >> (8 * byte)) & 0xFFU)) * 0x100000001B3ULL;
    }
  }
  /// The score counts where non-maxima are suppressed.
  void add(long u_px, long v_px, long score, bool suppress) {
    ++count;
    add_number(u_px);
    add_number(v_px);
    if (suppress) add_number(score);
  }
};

}  // namespace relnav::vision::test
