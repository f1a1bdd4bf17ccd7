// Boundary: an area that a map is cut to: polygons with holes on WGS 84, degrees. Edges are straight in Web
// Mercator, the grid of the tiles, and go the shorter way around the Earth. BoundaryOnZoom: which pixels of a
// tile lie within; MaskRings: the same for any grid. Files with areas are read by
// storage/exports/custom/boundary.h. Pure; any thread. Memory: 32 bytes a corner. Nothing fails.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geo/lat_lon_bounds.h"
#include "core/geo/tile_id.h"

namespace skyquilt::geo {

// Places counted in cells from a grid's corner, columns and rows as they rise.
struct RingEdge {
  double x0 = 0.0, y0 = 0.0, x1 = 0.0, y1 = 0.0;
};

// Part of the grid that is masked: its first cell, and how many.
struct MaskWindow {
  double left = 0.0, top = 0.0;
  std::size_t columns = 0, rows = 0;
};

// Which cells have their middles within rings of edges, by crossings along each row: even and odd, so that a
// hole is a ring like another. Memory: of the crossings of 256 rows. `inside`: row by row; cells within
// become 1, the others stay as they are.
void MaskRings(const std::vector<RingEdge>& edges, const MaskWindow& window,
               std::vector<std::uint8_t>& inside);

inline constexpr std::size_t kMaxBoundaryCorners = 100'000;

struct Boundary {
  using Ring = std::vector<LatLon>;
  using Polygon = std::vector<Ring>;  // the outline, then holes
  std::vector<Polygon> polygons;      // at least one

  LatLonBounds Bounds() const;
  friend bool operator==(const Boundary&, const Boundary&) = default;
};

// Square metres: the outlines less their holes.
double AreaM2(const Boundary& boundary);
// Whether two edges of one ring cross: then its area is none that one could mean. Edges that touch do not. Of
// rings of more than ten thousand corners that would take seconds not all edges are looked at.
bool CrossesItself(const Boundary& boundary);
// What of it lies within bounds, for what looks no further: rings cut one by one, so that parts may hang
// together along the border. No polygons: nothing does.
Boundary CutTo(const Boundary& boundary, const LatLonBounds& bounds);

enum class Cover { kNone, kPart, kAll };

// A boundary on the pixels of one zoom.
class BoundaryOnZoom {
 public:
  BoundaryOnZoom(const Boundary& boundary, int zoom, int tile_size_px);
  // `inside`: 1 for each pixel of the tile whose middle lies within, row by row from the north; else 0.
  Cover Mask(const TileId& tile, std::vector<std::uint8_t>& inside) const;
  // The same without the pixels, and quick away from the edges.
  Cover CoverOf(const TileId& tile) const;

 private:
  int tile_size_px_;
  std::vector<std::vector<RingEdge>> polygons_;  // pixels from the world's north-west corner
};

}  // namespace skyquilt::geo
