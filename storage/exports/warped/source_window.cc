#include "storage/exports/warped/source_window.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "storage/exports/fringe_tile.h"
#include "storage/exports/warped/resample_block.h"

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

SourceReach SourceReach::Of(const geo::LatLonBounds& bounds, double px_per_m) {
  const Eigen::Vector2d north_west = geo::MercFromLatLon({bounds.north_deg, bounds.west_deg});
  const double south_m = geo::MercFromLatLon({bounds.south_deg, bounds.west_deg}).y();
  const double width_m = (bounds.east_deg - bounds.west_deg) / 180.0 * geo::kMercHalfWidthM;
  const double west_m = north_west.x() + geo::kMercHalfWidthM;
  const auto before = [&](double metres) {
    return static_cast<std::int64_t>(std::floor(metres * px_per_m)) - 1;
  };
  const auto behind = [&](double metres) {
    return static_cast<std::int64_t>(std::ceil(metres * px_per_m)) + 1;
  };
  return {before(west_m), before(geo::kMercHalfWidthM - north_west.y()), behind(west_m + width_m),
          behind(geo::kMercHalfWidthM - south_m)};
}

SourceReach SourceReach::Within(const geo::Bounds2& bounds, double room) const {
  if (bounds.IsEmpty()) return {};
  const auto between = [](double px, std::int64_t low, std::int64_t high) {
    return static_cast<std::int64_t>(std::clamp(px, static_cast<double>(low), static_cast<double>(high)));
  };
  return {between(std::floor(bounds.min.x() - room), west, east),
          between(std::floor(bounds.min.y() - room), north, south),
          between(std::ceil(bounds.max.x() + room), west, east),
          between(std::ceil(bounds.max.y() + room), north, south)};
}

bool SourceReach::IsLargerThan(std::int64_t pixels) const {
  const std::int64_t width = east - west, height = south - north;
  return width > pixels || height > pixels || width * height > pixels;
}

Result<SourceWindow> LoadWindow(MapTiles& tiles, const SourceLevel& level, const SourceReach& reach) {
  SourceWindow window{reach.west, reach.north,
                      image::RgbaImage::Transparent(static_cast<int>(reach.east - reach.west),
                                                    static_cast<int>(reach.south - reach.north))};
  const std::int64_t side = level.tile_size_px, around = std::int64_t{1} << level.zoom;
  for (std::int64_t row = FloorDiv(reach.north, side); row * side < reach.south; ++row) {
    for (std::int64_t column = FloorDiv(reach.west, side); column * side < reach.east; ++column) {
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

Result<SourceWindow> LoadHalved(MapTiles& tiles, const SourceLevel& level, const SourceReach& reach,
                                int halvings) {
  const std::int64_t side = std::int64_t{1} << halvings;
  const auto before = [&](std::int64_t px) { return FloorDiv(px, side) * side; };
  const auto behind = [&](std::int64_t px) { return before(px + side - 1); };
  SKYQUILT_TRY_ASSIGN(SourceWindow window, LoadWindow(tiles, level,
                                                      {before(reach.west), before(reach.north),
                                                       behind(reach.east), behind(reach.south)}));
  for (int i = 0; i < halvings; ++i) window.pixels = Halved(window.pixels);
  window.left_px /= side;
  window.top_px /= side;
  return window;
}

}  // namespace skyquilt::storage
