#pragma once
// PNG files made by hand, with what no encoder of ours writes.
#include <zlib.h>

#include <cstdint>
#include <string>

namespace relnav::test {

inline void add_be32(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<char>((value >> shift) & 0xFFU));
}

inline void add_chunk(std::string& out, const std::string& type, const std::string& data) {
  add_be32(out, static_cast<std::uint32_t>(data.size()));
  const std::string body = type + data;
  out += body;
  add_be32(out, static_cast<std::uint32_t>(
                    ::crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
}

/// A PNG made by hand: rows are raw samples, each with the filter byte 0 in front.
inline std::string make_png(std::uint32_t width, std::uint32_t height, int bit_depth, int colour_type,
                            const std::string& rows) {
  std::string out("\x89PNG\r\n\x1a\n", 8);
  std::string header;
  add_be32(header, width);
  add_be32(header, height);
  header += {static_cast<char>(bit_depth), static_cast<char>(colour_type), 0, 0, 0};
  add_chunk(out, "IHDR", header);
  uLongf size = compressBound(static_cast<uLong>(rows.size()));
  std::string packed(size, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
           static_cast<uLong>(rows.size()));
  packed.resize(size);
  add_chunk(out, "IDAT", packed);
  add_chunk(out, "IEND", "");
  return out;
}

}  // namespace relnav::test
