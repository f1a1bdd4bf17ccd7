#include "storage/exports/warped/source_window.h"

#include <algorithm>
#include <cstring>

#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "storage/exports/fringe_tile.h"

namespace skyquilt::storage {
namespace {

std::int64_t FloorDiv(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }

void CopyInto(SourceWindow& window, const image::RgbaImage& tile, std::int64_t left_px, std::int64_t top_px) {
  const std::int64_t from_x = std::max(left_px, window.left_px);
  const std::int64_t to_x =
      std::min(left_px + tile.width_px, window.left_px + std::int64_t{window.pixels.width_px});
  const std::int64_t from_y = std::max(top_px, window.top_px);
  const std::int64_t to_y =
      std::min(top_px + tile.height_px, window.top_px + std::int64_t{window.pixels.height_px});
  if (from_x >= to_x) return;
  for (std::int64_t y = from_y; y < to_y; ++y) {
    std::memcpy(
        window.pixels.Pixel(static_cast<int>(from_x - window.left_px), static_cast<int>(y - window.top_px)),
        tile.Pixel(static_cast<int>(from_x - left_px), static_cast<int>(y - top_px)),
        4 * static_cast<std::size_t>(to_x - from_x));
  }
}

}  // namespace

Result<SourceWindow> LoadWindow(MapTiles& tiles, const SourceLevel& level, std::int64_t left_px,
                                std::int64_t top_px, int width_px, int height_px) {
  SourceWindow window{left_px, top_px, image::RgbaImage::Transparent(width_px, height_px)};
  const std::int64_t side = level.tile_size_px, around = std::int64_t{1} << level.zoom;
  for (std::int64_t row = FloorDiv(top_px, side); row * side < top_px + height_px; ++row) {
    for (std::int64_t column = FloorDiv(left_px, side); column * side < left_px + width_px; ++column) {
      const auto tile = geo::TileId::Make(level.zoom, column - FloorDiv(column, around) * around, row);
      if (!tile) continue;  // beyond the world's northern or southern edge
      SKYQUILT_TRY_ASSIGN(std::optional<FoundTile> found, tiles.Find(*tile));
      if (!found) continue;
      SKYQUILT_TRY_ASSIGN(const std::string bytes, tiles.Load(*std::move(found)));
      SKYQUILT_TRY_ASSIGN(const image::RgbaImage pixels, DecodeTile(bytes, level.tile_size_px));
      CopyInto(window, pixels, column * side, row * side);
    }
  }
  return window;
}

}  // namespace skyquilt::storage
