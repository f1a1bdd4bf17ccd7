#include "core/image/picture_codec.h"

#include <png.h>
#include <turbojpeg.h>
#include <webp/decode.h>
#include <webp/encode.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/image/png_decoder.h"
#include "core/image/png_encoder.h"
#include "core/image/png_tile.h"

namespace skyquilt::image {
namespace {

constexpr int kJpegQuality = 90;
constexpr float kWebpQuality = 90.0F;

using TurboHandle = std::unique_ptr<void, int (*)(tjhandle)>;

const std::uint8_t* Raw(std::string_view bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

Error Damaged() { return {ErrorCode::kCorrupt, "A stored tile is damaged. Stitch the flight again.", ""}; }

// Its pixels are yet to be written.
Result<RgbaImage> PictureOf(int width_px, int height_px) {
  if (width_px < 1 || height_px < 1 || width_px > kMaxPictureSidePx || height_px > kMaxPictureSidePx)
    return Error{ErrorCode::kTooLarge, "A stored tile is too large to be converted.", ""};
  RgbaImage image{width_px, height_px, {}};
  image.rgba.resize(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px) * 4);
  return image;
}

Result<RgbaImage> DecodeRgbaJpeg(std::string_view bytes) {
  const TurboHandle decoder(tjInitDecompress(), tjDestroy);
  int width_px = 0, height_px = 0, subsampling = 0, colors = 0;
  if (tjDecompressHeader3(decoder.get(), Raw(bytes), bytes.size(), &width_px, &height_px, &subsampling,
                          &colors) != 0) {
    return Damaged();
  }
  SKYQUILT_TRY_ASSIGN(RgbaImage image, PictureOf(width_px, height_px));
  // Alpha is set to 255.
  if (tjDecompress2(decoder.get(), Raw(bytes), bytes.size(), image.rgba.data(), width_px, 0, height_px,
                    TJPF_RGBA, TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS) != 0) {
    return Damaged();
  }
  return image;
}

Result<RgbaImage> DecodeRgbaPng(std::string_view bytes) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()) == 0) return Damaged();
  Result<RgbaImage> image = PictureOf(static_cast<int>(std::min(header.width, 1U << 20)),
                                      static_cast<int>(std::min(header.height, 1U << 20)));
  if (!image) {
    png_image_free(&header);
    return image;
  }
  if (image->width_px == image->height_px) {
    if (Result<RgbaImage> tile = DecodePngTile(bytes, image->width_px)) {
      png_image_free(&header);
      return tile;
    }
  }
  header.format = PNG_FORMAT_RGBA;
  if (!CheckPngEnds({Raw(bytes), bytes.size()})) {
    png_image_free(&header);
    return Damaged();
  }
  if (png_image_finish_read(&header, nullptr, image->rgba.data(), 0, nullptr) == 0) return Damaged();
  return image;
}

Result<RgbaImage> DecodeRgbaWebp(std::string_view bytes) {
  int width_px = 0, height_px = 0;
  if (WebPGetInfo(Raw(bytes), bytes.size(), &width_px, &height_px) == 0) return Damaged();
  SKYQUILT_TRY_ASSIGN(RgbaImage image, PictureOf(width_px, height_px));
  if (WebPDecodeRGBAInto(Raw(bytes), bytes.size(), image.rgba.data(), image.rgba.size(), width_px * 4) ==
      nullptr) {
    return Damaged();
  }
  return image;
}

void LayOnWhite(RgbaImage& image) {
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    const unsigned alpha = image.rgba[i + 3];
    for (std::size_t c = 0; c < 3; ++c) {
      const unsigned color = image.rgba[i + c];
      image.rgba[i + c] = static_cast<std::uint8_t>((color * alpha + 255U * (255U - alpha) + 127U) / 255U);
    }
  }
}

}  // namespace

PixelRows RowsOf(const RgbaImage& image) {
  return {image.rgba.data(), image.width_px, image.height_px, 4, 4 * image.width_px};
}

std::vector<std::uint8_t> EncodeJpeg(const PixelRows& pixels, int quality, ChromaSampling chroma) {
  const TurboHandle encoder(tjInitCompress(), tjDestroy);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int failed =
      tjCompress2(encoder.get(), pixels.first, pixels.width_px, pixels.row_bytes, pixels.height_px,
                  pixels.channels == 4 ? TJPF_RGBA : TJPF_RGB, &bytes, &size,
                  chroma == ChromaSampling::k420 ? TJSAMP_420 : TJSAMP_422, quality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(bytes, tjFree);
  if (failed != 0) throw std::runtime_error(std::string("JPEG encoder: ") + tjGetErrorStr2(encoder.get()));
  return {bytes, bytes + size};
}

Result<std::vector<std::uint8_t>> CutJpeg(std::string_view bytes, int left_px, int top_px, int side_px) {
  const TurboHandle cutter(tjInitTransform(), tjDestroy);
  int width_px = 0, height_px = 0, subsampling = 0, colors = 0;
  if (tjDecompressHeader3(cutter.get(), Raw(bytes), bytes.size(), &width_px, &height_px, &subsampling,
                          &colors) != 0 ||
      left_px + side_px > width_px || top_px + side_px > height_px) {
    return Damaged();
  }
  tjtransform square{};
  square.r = {left_px, top_px, side_px, side_px};
  square.op = TJXOP_NONE;
  square.options = TJXOPT_CROP | TJXOPT_COPYNONE;
  unsigned char* cut = nullptr;
  unsigned long size = 0;
  const int failed =
      tjTransform(cutter.get(), Raw(bytes), bytes.size(), 1, &cut, &size, &square, TJFLAG_LIMITSCANS);
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(cut, tjFree);
  if (failed != 0) return Damaged();
  return std::vector<std::uint8_t>(cut, cut + size);
}

std::vector<std::uint8_t> EncodeWebp(const PixelRows& pixels, float quality) {
  SKYQUILT_CHECK(pixels.channels == 4, "WebP is made of pixels with alpha");
  std::uint8_t* bytes = nullptr;
  const std::size_t size =
      WebPEncodeRGBA(pixels.first, pixels.width_px, pixels.height_px, pixels.row_bytes, quality, &bytes);
  const std::unique_ptr<std::uint8_t, void (*)(void*)> owner(bytes, WebPFree);
  if (size == 0) throw std::runtime_error("WebP encoder: no memory, or a picture of no size");
  return {bytes, bytes + size};
}

std::vector<std::uint8_t> EncodePlainPng(const RgbaImage& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width_px);
  header.height = static_cast<png_uint_32>(image.height_px);
  header.format = PNG_FORMAT_RGBA;
  png_alloc_size_t size = 0;
  const auto write = [&](void* memory) {
    if (png_image_write_to_memory(&header, memory, &size, 0, image.rgba.data(), 0, nullptr) == 0)
      throw std::runtime_error(std::string("PNG encoder: ") + header.message);
  };
  write(nullptr);  // how many bytes it takes
  std::vector<std::uint8_t> bytes(size);
  write(bytes.data());
  bytes.resize(size);
  return bytes;
}

std::vector<std::uint8_t> EncodePicture(RgbaImage image, PictureFormat format) {
  switch (format) {
    case PictureFormat::kJpeg:
      LayOnWhite(image);
      return EncodeJpeg(RowsOf(image), kJpegQuality);
    case PictureFormat::kPng:
      // Its alpha is straight already, as PNG has it.
      return EncodeWholePng(image);
    case PictureFormat::kWebp:
      return EncodeWebp(RowsOf(image), kWebpQuality);
  }
  SKYQUILT_CHECK(false, "a picture format outside the list");
}

bool IsYcbcrJpeg(std::string_view bytes) {
  const TurboHandle decoder(tjInitDecompress(), tjDestroy);
  int width_px = 0, height_px = 0, subsampling = 0, colors = 0;
  return tjDecompressHeader3(decoder.get(), Raw(bytes), bytes.size(), &width_px, &height_px, &subsampling,
                             &colors) == 0 &&
         colors == TJCS_YCbCr;
}

Result<RgbaImage> DecodePicture(std::string_view bytes) {
  const std::optional<PictureFormat> format = PictureFormatOf(bytes);
  if (!format) return Damaged();
  switch (*format) {
    case PictureFormat::kJpeg:
      return DecodeRgbaJpeg(bytes);
    case PictureFormat::kPng:
      return DecodeRgbaPng(bytes);
    case PictureFormat::kWebp:
      return DecodeRgbaWebp(bytes);
  }
  SKYQUILT_CHECK(false, "a picture format outside the list");
}

}  // namespace skyquilt::image
