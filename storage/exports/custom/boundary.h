// Boundary: the area that an export is cut to: polygons with holes on WGS 84, from GeoJSON (RFC 7946; also a
// Feature or FeatureCollection of polygons). Edges are straight in Web Mercator, the grid of the tiles. Pure;
// any thread. Memory: 32 bytes a corner. Errors: kInvalidArgument (no GeoJSON), kUnprocessable (no polygon,
// another coordinate system, too many corners).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/geo/tile_id.h"

namespace skyquilt::storage {

inline constexpr std::size_t kMaxBoundaryCorners = 100'000;
inline constexpr std::size_t kMaxBoundaryBytes = std::size_t{16} << 20;  // of its GeoJSON

struct Boundary {
  using Ring = std::vector<geo::LatLon>;
  using Polygon = std::vector<Ring>;  // the outline, then holes
  std::vector<Polygon> polygons;      // at least one

  geo::LatLonBounds Bounds() const;
};

Result<Boundary> ParseBoundary(std::string_view geojson);

enum class Cover { kNone, kPart, kAll };

// A boundary on the pixels of one zoom.
class BoundaryOnZoom {
 public:
  BoundaryOnZoom(const Boundary& boundary, int zoom, int tile_size_px);
  // `inside`: 1 for each pixel of the tile whose middle lies within, row by row from the north; else 0.
  Cover Mask(const geo::TileId& tile, std::vector<std::uint8_t>& inside) const;

 private:
  struct Edge {
    double x0 = 0.0, y0 = 0.0, x1 = 0.0, y1 = 0.0;  // pixels from the world's north-west corner
  };
  int tile_size_px_;
  std::vector<std::vector<Edge>> polygons_;
};

}  // namespace skyquilt::storage
