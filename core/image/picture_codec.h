// The codecs of small pictures: tiles of a map and of its preview, thumbnails, answers of the API. JPEG by
// libjpeg-turbo, WebP by libwebp, PNG by png_encoder and png_tile, and by libpng what those two are not for.
// (Photos are decoded in parts, by jpeg_decoder and png_decoder.) Deterministic. Any thread. Encoding pixels
// cannot fail but for want of memory (std::runtime_error, std::bad_alloc).
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/image/decoded_image.h"
#include "core/image/picture_format.h"
#include "core/image/rgba_image.h"

namespace skyquilt::image {

inline constexpr int kMaxPictureSidePx = 4096;

// Rows of 8-bit RGB or RGBA somewhere in a larger picture.
struct PixelRows {
  const std::uint8_t* first = nullptr;
  int width_px = 0;
  int height_px = 0;
  int channels = 4;
  int row_bytes = 0;
};
PixelRows RowsOf(const RgbaImage& image);

enum class ChromaSampling { k420, k422 };
// Alpha is left out, not laid on anything.
std::vector<std::uint8_t> EncodeJpeg(const PixelRows& pixels, int quality,
                                     ChromaSampling chroma = ChromaSampling::k420);
// Four channels, straight alpha.
std::vector<std::uint8_t> EncodeWebp(const PixelRows& pixels, float quality);
// What has hardly anything in it: smaller than png_encoder makes it, and slower. Straight alpha.
std::vector<std::uint8_t> EncodePlainPng(const RgbaImage& image);

// A square of a JPEG as it is, without loss: its blocks are copied. Left and top are multiples of 16. Errors:
// kCorrupt (bytes that are no JPEG, or one that the square is not within).
Result<std::vector<std::uint8_t>> CutJpeg(std::string_view bytes, int left_px, int top_px, int side_px);

// Whether it is a JPEG of luma and chroma, the only ones that a GeoTIFF's tiles can be: others are grey, RGB
// or CMYK.
bool IsYcbcrJpeg(std::string_view bytes);

// For who asked for a format, in a quality fit for looking at. Straight alpha; JPEG, which has none, is laid
// on white.
std::vector<std::uint8_t> EncodePicture(RgbaImage image, PictureFormat format);

// JPEG, PNG or WebP, with straight alpha. Errors: kCorrupt (bytes that do not decode, another format),
// kTooLarge (a side of more than kMaxPictureSidePx).
Result<RgbaImage> DecodePicture(std::string_view bytes);

}  // namespace skyquilt::image
