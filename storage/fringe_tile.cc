#include "storage/fringe_tile.h"

#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <stdexcept>

namespace skyquilt::storage {
namespace {

constexpr int kChannels = 4;
constexpr std::uint8_t kCoveredAlpha = 128;

struct Canvas {
  int side_px = 0;
  std::vector<std::uint8_t> rgba;
  std::uint8_t* Row(int y) { return rgba.data() + static_cast<std::size_t>(y) * side_px * kChannels; }
};

// Lends each pixel without colour that of its nearest neighbour in the row. False: the row has none at all.
bool FillRow(std::uint8_t* row, int side_px) {
  int last = -1;
  for (int x = 0; x < side_px; ++x) {
    if (row[x * kChannels + 3] == 0) continue;
    const int middle = last < 0 ? 0 : (last + x + 1) / 2;
    for (int i = last + 1; i < x; ++i) {
      std::memcpy(row + i * kChannels, row + (i < middle ? last : x) * kChannels, 3);
    }
    last = x;
  }
  for (int i = last + 1; last >= 0 && i < side_px; ++i)
    std::memcpy(row + i * kChannels, row + last * kChannels, 3);
  return last >= 0;
}

void FillOutside(Canvas& canvas) {
  int last = -1;
  const std::size_t row_bytes = static_cast<std::size_t>(canvas.side_px) * kChannels;
  for (int y = 0; y < canvas.side_px; ++y) {
    if (!FillRow(canvas.Row(y), canvas.side_px)) continue;
    const int middle = last < 0 ? 0 : (last + y + 1) / 2;
    for (int i = last + 1; i < y; ++i)
      std::memcpy(canvas.Row(i), canvas.Row(i < middle ? last : y), row_bytes);
    last = y;
  }
  for (int i = last + 1; last >= 0 && i < canvas.side_px; ++i)
    std::memcpy(canvas.Row(i), canvas.Row(last), row_bytes);
}

std::string EncodeJpeg(const Canvas& canvas, int quality) {
  const std::unique_ptr<void, int (*)(tjhandle)> encoder(tjInitCompress(), tjDestroy);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int failed = tjCompress2(encoder.get(), canvas.rgba.data(), canvas.side_px, 0, canvas.side_px,
                                 TJPF_RGBA, &bytes, &size, TJSAMP_420, quality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(bytes, tjFree);
  if (failed != 0) throw std::runtime_error(std::string("JPEG encoder: ") + tjGetErrorStr2(encoder.get()));
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace

Result<FringeTile> SplitAlpha(std::string_view png, int tile_size_px, int jpeg_quality) {
  const Error damaged{ErrorCode::kCorrupt, "a stored tile is damaged; stitch the flight again", ""};
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&image, png.data(), png.size()) == 0) return damaged;
  const auto side = static_cast<png_uint_32>(tile_size_px);
  if (image.width != side || image.height != side) {
    png_image_free(&image);
    return damaged;
  }
  image.format = PNG_FORMAT_RGBA;
  Canvas canvas{tile_size_px, std::vector<std::uint8_t>(static_cast<std::size_t>(side) * side * kChannels)};
  if (png_image_finish_read(&image, nullptr, canvas.rgba.data(), 0, nullptr) == 0) return damaged;

  FringeTile fringe;
  const std::size_t row_bytes = (side + 7) / 8;
  fringe.mask_bits.assign(row_bytes * side, 0);
  for (int y = 0; y < tile_size_px; ++y) {
    const std::uint8_t* row = canvas.Row(y);
    for (int x = 0; x < tile_size_px; ++x) {
      if (row[x * kChannels + 3] < kCoveredAlpha) continue;
      fringe.mask_bits[static_cast<std::size_t>(y) * row_bytes + static_cast<std::size_t>(x) / 8] |=
          static_cast<std::uint8_t>(0x80 >> (x % 8));
    }
  }
  FillOutside(canvas);
  fringe.jpeg = EncodeJpeg(canvas, jpeg_quality);
  return fringe;
}

}  // namespace skyquilt::storage
