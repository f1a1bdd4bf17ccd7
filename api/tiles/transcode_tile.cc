#include "api/tiles/transcode_tile.h"

#include <png.h>
#include <turbojpeg.h>
#include <webp/decode.h>
#include <webp/encode.h>

#include <cstring>
#include <memory>
#include <vector>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/pyramid/png_encoder.h"

namespace skyquilt::api {
namespace {

using pyramid::TileFormat;

constexpr int kJpegQuality = 90;
constexpr float kWebpQuality = 90.0F;

const std::uint8_t* Raw(std::string_view bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

Error Damaged() { return {ErrorCode::kCorrupt, "A stored tile is damaged. Stitch the flight again.", ""}; }

Result<void> Resize(Pixels* pixels, int width, int height) {
  if (width < 1 || height < 1 || width > kMaxSidePx || height > kMaxSidePx) {
    return Error{ErrorCode::kTooLarge, "A stored tile is too large to be converted.", ""};
  }
  pixels->width = width;
  pixels->height = height;
  pixels->rgba.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4);
  return {};
}

using TurboHandle = std::unique_ptr<void, decltype(&tjDestroy)>;

Result<Pixels> DecodeJpeg(std::string_view bytes) {
  const TurboHandle jpeg(tjInitDecompress(), &tjDestroy);
  Pixels pixels;
  int width = 0;
  int height = 0;
  int subsampling = 0;
  int colorspace = 0;
  if (tjDecompressHeader3(jpeg.get(), Raw(bytes), bytes.size(), &width, &height, &subsampling, &colorspace) !=
      0) {
    return Damaged();
  }
  SKYQUILT_TRY(Resize(&pixels, width, height));
  if (tjDecompress2(jpeg.get(), Raw(bytes), bytes.size(), pixels.rgba.data(), width, 0, height, TJPF_RGBA,
                    0) != 0) {
    return Damaged();
  }
  return pixels;
}

Result<Pixels> DecodePng(std::string_view bytes) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) == 0) return Damaged();
  Pixels pixels;
  const Result<void> sized = Resize(&pixels, static_cast<int>(std::min(image.width, 1U << 20)),
                                    static_cast<int>(std::min(image.height, 1U << 20)));
  if (!sized) {
    png_image_free(&image);
    return sized.error();
  }
  image.format = PNG_FORMAT_RGBA;
  if (png_image_finish_read(&image, nullptr, pixels.rgba.data(), 0, nullptr) == 0) return Damaged();
  return pixels;
}

Result<Pixels> DecodeWebp(std::string_view bytes) {
  Pixels pixels;
  int width = 0;
  int height = 0;
  if (WebPGetInfo(Raw(bytes), bytes.size(), &width, &height) == 0) return Damaged();
  SKYQUILT_TRY(Resize(&pixels, width, height));
  if (WebPDecodeRGBAInto(Raw(bytes), bytes.size(), pixels.rgba.data(), pixels.rgba.size(), width * 4) ==
      nullptr) {
    return Damaged();
  }
  return pixels;
}

void LayOnWhite(Pixels* pixels) {
  for (std::size_t i = 0; i < pixels->rgba.size(); i += 4) {
    const unsigned alpha = pixels->rgba[i + 3];
    for (std::size_t c = 0; c < 3; ++c) {
      const unsigned color = pixels->rgba[i + c];
      pixels->rgba[i + c] = static_cast<std::uint8_t>((color * alpha + 255U * (255U - alpha) + 127U) / 255U);
    }
  }
}

std::string EncodeJpeg(Pixels pixels) {
  LayOnWhite(&pixels);
  const TurboHandle jpeg(tjInitCompress(), &tjDestroy);
  unsigned char* encoded = nullptr;
  unsigned long size = 0;
  const int failed = tjCompress2(jpeg.get(), pixels.rgba.data(), pixels.width, 0, pixels.height, TJPF_RGBA,
                                 &encoded, &size, TJSAMP_420, kJpegQuality, 0);
  SKYQUILT_CHECK(failed == 0, "valid pixels did not encode");
  std::string bytes(reinterpret_cast<const char*>(encoded), size);
  tjFree(encoded);
  return bytes;
}

// Photographs: many times faster than libpng, and about as small.
std::string EncodePng(const Pixels& pixels) {
  pyramid::RgbaImage image{pixels.width, pixels.height, {}};
  image.rgba.resize(pixels.rgba.size());
  std::memcpy(image.rgba.data(), pixels.rgba.data(), pixels.rgba.size());
  // The pixels' alpha is straight already, as PNG has it.
  const std::vector<std::uint8_t> png = pyramid::EncodeWholePng(image, pyramid::PngAlpha::kAsItIs);
  return std::string(reinterpret_cast<const char*>(png.data()), png.size());
}

// What has hardly anything in it: by the general compressor.
std::string EncodePlainPng(const Pixels& pixels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(pixels.width);
  image.height = static_cast<png_uint_32>(pixels.height);
  image.format = PNG_FORMAT_RGBA;
  png_alloc_size_t size = 0;
  SKYQUILT_CHECK(png_image_write_to_memory(&image, nullptr, &size, 0, pixels.rgba.data(), 0, nullptr) != 0,
                 "valid pixels did not encode");
  std::string bytes(size, '\0');
  SKYQUILT_CHECK(
      png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.rgba.data(), 0, nullptr) != 0,
      "valid pixels did not encode");
  bytes.resize(size);
  return bytes;
}

std::string EncodeWebp(const Pixels& pixels) {
  std::uint8_t* encoded = nullptr;
  const std::size_t size = WebPEncodeRGBA(pixels.rgba.data(), pixels.width, pixels.height, pixels.width * 4,
                                          kWebpQuality, &encoded);
  SKYQUILT_CHECK(size > 0, "valid pixels did not encode");
  std::string bytes(reinterpret_cast<const char*>(encoded), size);
  WebPFree(encoded);
  return bytes;
}

}  // namespace

Result<Pixels> DecodeTile(std::string_view bytes) {
  const std::optional<TileFormat> from = TileFormatOf(bytes);
  if (!from) return Damaged();
  switch (*from) {
    case TileFormat::kJpeg:
      return DecodeJpeg(bytes);
    case TileFormat::kPng:
      return DecodePng(bytes);
    case TileFormat::kWebp:
      return DecodeWebp(bytes);
  }
  SKYQUILT_CHECK(false, "a tile format outside the list");
}

std::optional<TileFormat> TileFormatOf(std::string_view bytes) {
  if (bytes.starts_with("\xff\xd8\xff")) return TileFormat::kJpeg;
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return TileFormat::kPng;
  if (bytes.size() >= 12 && bytes.starts_with("RIFF") && bytes.substr(8, 4) == "WEBP")
    return TileFormat::kWebp;
  return std::nullopt;
}

const char* ContentTypeOf(TileFormat format) {
  return format == TileFormat::kJpeg ? "image/jpeg" : format == TileFormat::kPng ? "image/png" : "image/webp";
}

const char* ExtensionOf(TileFormat format) {
  return format == TileFormat::kJpeg ? "jpg" : format == TileFormat::kPng ? "png" : "webp";
}

std::string EncodeTile(Pixels pixels, TileFormat to) {
  switch (to) {
    case TileFormat::kJpeg:
      return EncodeJpeg(std::move(pixels));
    case TileFormat::kPng:
      return EncodePng(pixels);
    case TileFormat::kWebp:
      return EncodeWebp(pixels);
  }
  SKYQUILT_CHECK(false, "a tile format outside the list");
}

Result<std::string> TranscodeTile(std::string_view bytes, TileFormat to) {
  SKYQUILT_TRY_ASSIGN(Pixels pixels, DecodeTile(bytes));
  return EncodeTile(std::move(pixels), to);
}

std::string TransparentPng(int side_px) {
  Pixels pixels;
  const Result<void> sized = Resize(&pixels, side_px, side_px);
  SKYQUILT_CHECK(sized.ok(), "an empty tile of no sensible size");
  return EncodePlainPng(pixels);
}

std::optional<int> TileSidePx(std::string_view bytes) {
  const Result<Pixels> pixels = DecodeTile(bytes);
  if (!pixels) return std::nullopt;
  return pixels->width;
}

}  // namespace skyquilt::api
