#include <png.h>

#include <bit>
#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <utility>

#include "hil/io/image.hpp"
#include "platform/files/input_error.hpp"

namespace relnav::hil {
namespace {

constexpr std::uint32_t largest_side_px = 16384;
constexpr std::size_t message_bytes = 160;

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

// libpng reports errors by longjmp: everything between setjmp and the return is plain data.
struct Decoder {
  png_structp png = nullptr;
  png_infop info = nullptr;
  char message[message_bytes] = "damaged";
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  int channels = 0;
  int bit_depth = 0;

  Decoder() = default;
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
  ~Decoder() { png_destroy_read_struct(&png, &info, nullptr); }
};

[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  auto* decoder = static_cast<Decoder*>(png_get_error_ptr(png));
  std::snprintf(decoder->message, message_bytes, "%s", message);
  png_longjmp(png, 1);
}
void on_warning(png_structp, png_const_charp) {}

bool read_header(Decoder& d, std::FILE* file) {
  if (setjmp(png_jmpbuf(d.png)) != 0) return false;
  png_init_io(d.png, file);
  png_set_user_limits(d.png, largest_side_px, largest_side_px);
  png_read_info(d.png, d.info);
  if (png_get_color_type(d.png, d.info) == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(d.png);
  if (png_get_bit_depth(d.png, d.info) < 8) png_set_expand_gray_1_2_4_to_8(d.png);
  png_set_strip_alpha(d.png);
  if (std::endian::native == std::endian::little) png_set_swap(d.png);
  png_set_interlace_handling(d.png);
  png_read_update_info(d.png, d.info);
  d.width = png_get_image_width(d.png, d.info);
  d.height = png_get_image_height(d.png, d.info);
  d.channels = png_get_channels(d.png, d.info);
  d.bit_depth = png_get_bit_depth(d.png, d.info);
  return true;
}

bool read_rows(Decoder& d, png_bytepp rows) {
  if (setjmp(png_jmpbuf(d.png)) != 0) return false;
  png_read_image(d.png, rows);
  png_read_end(d.png, nullptr);
  return true;
}

struct Encoder {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::vector<std::uint8_t> bytes;

  Encoder() = default;
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
  ~Encoder() { png_destroy_write_struct(&png, &info); }
};

[[noreturn]] void on_write_error(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void on_bytes(png_structp png, png_bytep bytes, std::size_t size) {
  auto& all = static_cast<Encoder*>(png_get_io_ptr(png))->bytes;
  all.insert(all.end(), bytes, bytes + size);
}
void on_flush(png_structp) {}

bool write_rows(Encoder& e, const Image& image, PngEffort effort, const png_const_bytep* rows) {
  if (setjmp(png_jmpbuf(e.png)) != 0) return false;
  png_set_write_fn(e.png, &e, on_bytes, on_flush);
  if (effort == PngEffort::fast) png_set_compression_level(e.png, 1);
  png_set_IHDR(e.png, e.info, image.width_px, image.height_px, 8 * static_cast<int>(image.bytes_per_pixel),
               PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(e.png, e.info);
  if (image.bytes_per_pixel == 2 && std::endian::native == std::endian::little) png_set_swap(e.png);
  for (std::uint32_t v = 0; v < image.height_px; ++v) png_write_row(e.png, rows[v]);
  png_write_end(e.png, nullptr);
  return true;
}

std::uint32_t luma(std::uint32_t red, std::uint32_t green, std::uint32_t blue) {
  return (299U * red + 587U * green + 114U * blue + 500U) / 1000U;
}

void colour_to_grey(Image& image) {
  const std::size_t pixels = std::size_t{image.width_px} * image.height_px;
  if (image.bytes_per_pixel == 1) {
    for (std::size_t i = 0; i < pixels; ++i) {
      const std::uint8_t* p = &image.bytes[3 * i];
      image.bytes[i] = static_cast<std::uint8_t>(luma(p[0], p[1], p[2]));
    }
  } else {
    for (std::size_t i = 0; i < pixels; ++i) {
      std::uint16_t rgb[3];
      std::memcpy(rgb, &image.bytes[6 * i], sizeof rgb);
      const auto grey = static_cast<std::uint16_t>(luma(rgb[0], rgb[1], rgb[2]));
      std::memcpy(&image.bytes[2 * i], &grey, sizeof grey);
    }
  }
  image.bytes.resize(pixels * image.bytes_per_pixel);
}

}  // namespace

Image read_png(const std::string& path) {
  const std::string expectation = "a complete PNG image";
  const File file(std::fopen(path.c_str(), "rb"));
  if (!file) throw InputError(path, 0, std::string("cannot be opened: ") + std::strerror(errno), expectation);
  png_byte signature[8] = {};
  if (std::fread(signature, 1, sizeof signature, file.get()) != sizeof signature || png_sig_cmp(signature, 0, 8) != 0) {
    throw InputError(path, 0, "no PNG signature", expectation);
  }
  std::rewind(file.get());
  Decoder decoder;
  decoder.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &decoder, on_error, on_warning);
  decoder.info = decoder.png != nullptr ? png_create_info_struct(decoder.png) : nullptr;
  if (decoder.info == nullptr) throw std::runtime_error("libpng: out of memory");
  const auto fail = [&] {
    throw InputError(path, 0, std::string("damaged or truncated (") + decoder.message + ")", expectation);
  };
  if (!read_header(decoder, file.get())) fail();

  Image image;
  image.width_px = decoder.width;
  image.height_px = decoder.height;
  image.bytes_per_pixel = decoder.bit_depth == 16 ? 2 : 1;
  const std::size_t row_bytes =
      std::size_t{decoder.width} * static_cast<std::size_t>(decoder.channels) * image.bytes_per_pixel;
  image.bytes.resize(row_bytes * decoder.height);
  std::vector<png_bytep> rows(decoder.height);
  for (std::size_t v = 0; v < rows.size(); ++v) rows[v] = &image.bytes[v * row_bytes];
  if (!read_rows(decoder, rows.data())) fail();
  if (decoder.channels == 3) colour_to_grey(image);
  return image;
}

void keep_upper_bytes(Image& image) {
  if (image.bytes_per_pixel == 1) return;
  const std::size_t pixels = std::size_t{image.width_px} * image.height_px;
  for (std::size_t i = 0; i < pixels; ++i) {
    std::uint16_t sample = 0;
    std::memcpy(&sample, &image.bytes[2 * i], sizeof sample);
    image.bytes[i] = static_cast<std::uint8_t>(sample >> 8U);
  }
  image.bytes.resize(pixels);
  image.bytes_per_pixel = 1;
}

std::vector<std::uint8_t> encode_png(const Image& image, PngEffort effort) {
  Encoder encoder;
  encoder.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &encoder, on_write_error, on_warning);
  encoder.info = encoder.png != nullptr ? png_create_info_struct(encoder.png) : nullptr;
  const std::size_t row_bytes = std::size_t{image.width_px} * image.bytes_per_pixel;
  const bool consistent =
      image.bytes_per_pixel >= 1 && image.bytes_per_pixel <= 2 && image.bytes.size() == row_bytes * image.height_px;
  if (encoder.info == nullptr || !consistent) throw std::runtime_error("cannot encode an image");
  std::vector<png_const_bytep> rows(image.height_px);
  for (std::size_t v = 0; v < rows.size(); ++v) rows[v] = &image.bytes[v * row_bytes];
  if (!write_rows(encoder, image, effort, rows.data())) throw std::runtime_error("cannot encode an image");
  return std::move(encoder.bytes);
}

void write_png(const std::string& path, const Image& image) {
  const std::vector<std::uint8_t> bytes = encode_png(image, PngEffort::fast);
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw InputError(path, 0, "cannot be written", "room and permission to write");
}

}  // namespace relnav::hil
