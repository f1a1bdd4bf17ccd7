// TileId: one tile of the Web Mercator quadtree. x counts from the west, y from the NORTH (XYZ, as browsers
// and OGC WebMercatorQuad have it); the TMS row of MBTiles is asked for by name and nowhere else computed. A
// value that is valid by construction; any thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <compare>
#include <cstdint>

#include "core/base/result.h"
#include "core/geo/bounds.h"

namespace skyquilt::geo {

inline constexpr int kMaxZoom = 30;

class TileId {
 public:
  TileId() = default;  // the whole world, 0/0/0
  // Refuses a zoom outside 0..30 and a column or row outside the zoom's square.
  static Result<TileId> Make(std::int64_t z, std::int64_t x, std::int64_t y);
  // The tile of a zoom that holds a merc point (points beyond the square go to the nearest tile).
  static TileId AtMerc(int zoom, const Eigen::Vector2d& point_in_merc);

  int z() const { return z_; }
  std::uint32_t x() const { return x_; }
  std::uint32_t y() const { return y_; }
  std::uint32_t TmsRow() const { return (1u << z_) - 1u - y_; }

  TileId Parent() const;                   // not of zoom 0
  std::array<TileId, 4> Children() const;  // north-west, north-east, south-west, south-east
  Bounds2 BoundsInMerc() const;

  auto operator<=>(const TileId&) const = default;

 private:
  TileId(int z, std::uint32_t x, std::uint32_t y) : z_(z), x_(x), y_(y) {}
  int z_ = 0;
  std::uint32_t x_ = 0;
  std::uint32_t y_ = 0;
};

// Side of a tile in merc metres, and of one of its pixels.
double TileSizeInMercM(int zoom);
double PixelSizeInMercM(int zoom, int tile_size_px);
// The smallest zoom whose pixels, at this latitude, are not larger on the ground than gsd_m.
int ZoomForGsd(double gsd_m, double lat_deg, int tile_size_px);

// Place of a cell along the Hilbert curve of a 2^order square. The children of a quadtree
// cell are neighbours on the curve, so a pyramid can be closed as the walk leaves each parent. Source: D.
// Hilbert (1891); iterative form after C. H. Hamilton, Compact Hilbert Indices (2006).
std::uint64_t HilbertIndex(int order, std::uint32_t x, std::uint32_t y);

}  // namespace skyquilt::geo
