// GeoJsonShape: a geometry of GeoJSON (RFC 7946: points, lines, polygons, many of them, collections), and
// whether it meets a rectangle. Straight edges in degrees. A value that may be moved; once made, any thread.
// Memory: some 100 bytes a position. Errors: kInvalidArgument (no geometry, or one of more than kMaxPositions
// positions; the message says what is wrong).
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "core/base/result.h"
#include "core/geo/lat_lon_bounds.h"

namespace skyquilt::storage {

class GeoJsonShape {
 public:
  static constexpr std::size_t kMaxPositions = 100'000;

  // Of a geometry's own text: no Feature.
  static Result<GeoJsonShape> Parse(std::string_view geometry);
  GeoJsonShape(GeoJsonShape&&) noexcept;
  GeoJsonShape& operator=(GeoJsonShape&&) noexcept;
  ~GeoJsonShape();

  // Also where they have only an edge or a point in common. Beyond the antimeridian a rectangle is seen from
  // both sides.
  bool Meets(const geo::LatLonBounds& box) const;

 private:
  struct Geometry;
  explicit GeoJsonShape(std::unique_ptr<Geometry> geometry);
  std::unique_ptr<Geometry> geometry_;
};

}  // namespace skyquilt::storage
