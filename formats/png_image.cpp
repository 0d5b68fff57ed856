// SPDX-License-Identifier: Apache-2.0
#include "formats/png_image.h"

#include <png.h>

#include <csetjmp>
#include <vector>

namespace diesink {
namespace {

struct Target {
  ByteSink* sink;
  Status status = ok();
};

void put(png_structp png, png_bytep bytes, std::size_t size) {
  auto* target = static_cast<Target*>(png_get_io_ptr(png));
  if (target->status) target->status = target->sink->put(std::as_bytes(std::span(bytes, size)));
}

void flush(png_structp) {}

}  // namespace

Status write_png(std::size_t width, std::size_t height, std::span<const std::uint8_t> rgb,
                 ByteSink& sink) {
  const Error refused{ErrorCode::kLimit, "the picture is too large for PNG", {}};
  constexpr std::size_t kMost = 1'000'000;
  if (width > kMost || height > kMost) return refused;
  Target target{&sink};
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  if (png == nullptr) return refused;
  png_infop info = png_create_info_struct(png);
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return refused;
  }
  png_set_write_fn(png, &target, put, flush);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 8,
               PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (std::size_t j = 0; j < height; ++j) png_write_row(png, rgb.data() + 3 * width * j);
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return target.status;
}

}  // namespace diesink
