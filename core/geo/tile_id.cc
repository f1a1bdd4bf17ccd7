#include "core/geo/tile_id.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/geo/web_mercator.h"

namespace skyquilt::geo {

Result<TileId> TileId::Make(std::int64_t z, std::int64_t x, std::int64_t y) {
  if (z < 0 || z > kMaxZoom) {
    return Error{ErrorCode::kInvalidArgument, "Tile zoom must be 0.." + std::to_string(kMaxZoom) + ".", ""};
  }
  const std::int64_t side = std::int64_t{1} << z;
  if (x < 0 || x >= side || y < 0 || y >= side) {
    return Error{
        ErrorCode::kInvalidArgument,
        "Tile column and row must be 0.." + std::to_string(side - 1) + " at zoom " + std::to_string(z) + ".",
        ""};
  }
  return TileId(static_cast<int>(z), static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
}

TileId TileId::AtMerc(int zoom, const Eigen::Vector2d& point_in_merc) {
  SKYQUILT_CHECK(zoom >= 0 && zoom <= kMaxZoom, "zoom out of range");
  const double side = std::ldexp(1.0, zoom);
  const double size_m = TileSizeInMercM(zoom);
  const auto index = [&](double from_edge_m) {
    return static_cast<std::uint32_t>(std::clamp(std::floor(from_edge_m / size_m), 0.0, side - 1.0));
  };
  return {zoom, index(point_in_merc.x() + kMercHalfWidthM), index(kMercHalfWidthM - point_in_merc.y())};
}

TileId TileId::Parent() const {
  SKYQUILT_CHECK(z_ > 0, "the world tile has no parent");
  return {z_ - 1, x_ >> 1, y_ >> 1};
}

std::array<TileId, 4> TileId::Children() const {
  SKYQUILT_CHECK(z_ < kMaxZoom, "no tiles below the last zoom");
  return {TileId(z_ + 1, 2 * x_, 2 * y_), TileId(z_ + 1, 2 * x_ + 1, 2 * y_),
          TileId(z_ + 1, 2 * x_, 2 * y_ + 1), TileId(z_ + 1, 2 * x_ + 1, 2 * y_ + 1)};
}

Bounds2 TileId::BoundsInMerc() const {
  const double size_m = TileSizeInMercM(z_);
  Bounds2 bounds;
  bounds.min = {x_ * size_m - kMercHalfWidthM, kMercHalfWidthM - (y_ + 1.0) * size_m};
  bounds.max = {(x_ + 1.0) * size_m - kMercHalfWidthM, kMercHalfWidthM - y_ * size_m};
  return bounds;
}

double TileSizeInMercM(int zoom) { return std::ldexp(2.0 * kMercHalfWidthM, -zoom); }

double PixelSizeInMercM(int zoom, int tile_size_px) { return TileSizeInMercM(zoom) / tile_size_px; }

int ZoomForGsd(double gsd_m, double lat_deg, int tile_size_px) {
  SKYQUILT_CHECK(gsd_m > 0.0 && tile_size_px > 0, "ground sampling distance and tile size must be positive");
  const double world_px = 2.0 * kMercHalfWidthM * GroundMetresPerMercMetre(lat_deg) / (gsd_m * tile_size_px);
  return static_cast<int>(
      std::clamp(std::ceil(std::log2(world_px) - 1e-9), 0.0, static_cast<double>(kMaxZoom)));
}

std::uint64_t HilbertIndex(int order, std::uint32_t x, std::uint32_t y) {
  std::uint64_t index = 0;
  for (int level = order - 1; level >= 0; --level) {
    const std::uint32_t right = (x >> level) & 1u;
    const std::uint32_t lower = (y >> level) & 1u;
    index = (index << 2) | ((3u * right) ^ lower);
    if (lower == 0) {  // the curve turns inside this quadrant
      if (right == 1) {
        const std::uint32_t mask = (level == 31) ? ~0u : ((1u << (level + 1)) - 1u);
        x = ~x & mask;
        y = ~y & mask;
      }
      std::swap(x, y);
    }
  }
  return index;
}

}  // namespace skyquilt::geo
