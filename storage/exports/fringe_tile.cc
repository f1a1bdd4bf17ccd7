#include "storage/exports/fringe_tile.h"

#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "core/base/try.h"
#include "storage/exports/png_tile.h"

namespace skyquilt::storage {
namespace {

constexpr std::uint8_t kCoveredAlpha = 128;

// What JPEG codes together with 4:2:0.
constexpr int kUnitPx = 16;

// Beyond the edge, but within its JPEG unit, the mean of the covered pixels; black farther out.
void FillOutside(TileCanvas& canvas) {
  for (int top = 0; top < canvas.side_px; top += kUnitPx) {
    for (int left = 0; left < canvas.side_px; left += kUnitPx) {
      const int bottom = std::min(top + kUnitPx, canvas.side_px),
                right = std::min(left + kUnitPx, canvas.side_px);
      int covered = 0;
      for (int y = top; y < bottom; ++y) {
        const std::uint8_t* alpha = canvas.At(left, y) + 3;
        for (int x = left; x < right; ++x, alpha += 4) covered += *alpha >= kCoveredAlpha ? 1 : 0;
      }
      if (covered == (bottom - top) * (right - left)) continue;
      if (covered == 0) {
        for (int y = top; y < bottom; ++y)
          std::fill(canvas.At(left, y), canvas.At(right - 1, y) + 3, std::uint8_t{0});
        continue;
      }
      const auto visit = [&](auto&& act) {
        for (int y = top; y < bottom; ++y) {
          for (int x = left; x < right; ++x) act(canvas.At(x, y));
        }
      };
      std::array<int, 3> sum{};
      visit([&](const std::uint8_t* pixel) {
        if (pixel[3] < kCoveredAlpha) return;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += pixel[c];
      });
      visit([&](std::uint8_t* pixel) {
        if (pixel[3] >= kCoveredAlpha) return;
        for (std::size_t c = 0; c < 3; ++c)
          pixel[c] = static_cast<std::uint8_t>((sum[c] + covered / 2) / covered);
      });
    }
  }
}

std::string EncodeJpeg(const TileCanvas& canvas, int quality) {
  const std::unique_ptr<void, int (*)(tjhandle)> encoder(tjInitCompress(), tjDestroy);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int failed = tjCompress2(encoder.get(), canvas.rgba.data(), canvas.side_px, 0, canvas.side_px,
                                 TJPF_RGBA, &bytes, &size, TJSAMP_420, quality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(bytes, tjFree);
  if (failed != 0) throw std::runtime_error(std::string("JPEG encoder: ") + tjGetErrorStr2(encoder.get()));
  return {reinterpret_cast<const char*>(bytes), size};
}

Error Damaged() { return {ErrorCode::kCorrupt, "a stored tile is damaged; stitch the flight again", ""}; }

Result<TileCanvas> DecodePng(std::string_view bytes, int side_px) {
  SKYQUILT_TRY_ASSIGN(auto rgba, DecodePngTile(bytes, side_px));
  return TileCanvas{side_px, std::move(rgba)};
}

Result<TileCanvas> DecodeJpeg(std::string_view bytes, int side_px) {
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width_px = 0, height_px = 0, subsampling = 0, colors = 0;
  if (tjDecompressHeader3(decoder.get(), data, bytes.size(), &width_px, &height_px, &subsampling, &colors) !=
          0 ||
      width_px != side_px || height_px != side_px) {
    return Damaged();
  }
  TileCanvas canvas = TileCanvas::Transparent(side_px);
  // Alpha is set to 255.
  if (tjDecompress2(decoder.get(), data, bytes.size(), canvas.rgba.data(), side_px, 0, side_px, TJPF_RGBA,
                    TJFLAG_ACCURATEDCT) != 0) {
    return Damaged();
  }
  return canvas;
}

}  // namespace

TileCanvas TileCanvas::Transparent(int side_px) {
  return {side_px, std::vector<std::uint8_t>(4 * static_cast<std::size_t>(side_px) * side_px)};
}

Result<TileCanvas> DecodeTile(std::string_view bytes, int tile_size_px) {
  return bytes.starts_with("\x89PNG") ? DecodePng(bytes, tile_size_px) : DecodeJpeg(bytes, tile_size_px);
}

FringeTile SplitAlpha(TileCanvas canvas, int jpeg_quality) {
  FringeTile fringe;
  const std::size_t row_bytes = (static_cast<std::size_t>(canvas.side_px) + 7) / 8;
  fringe.mask_bits.assign(row_bytes * static_cast<std::size_t>(canvas.side_px), 0);
  for (int y = 0; y < canvas.side_px; ++y) {
    std::uint8_t* bits = fringe.mask_bits.data() + static_cast<std::size_t>(y) * row_bytes;
    for (int x = 0; x < canvas.side_px; ++x)
      bits[x / 8] |= static_cast<std::uint8_t>((canvas.At(x, y)[3] >= kCoveredAlpha ? 0x80 : 0) >> (x % 8));
    fringe.is_empty &= std::all_of(bits, bits + row_bytes, [](std::uint8_t eight) { return eight == 0; });
  }
  FillOutside(canvas);
  fringe.jpeg = EncodeJpeg(canvas, jpeg_quality);
  return fringe;
}

}  // namespace skyquilt::storage
