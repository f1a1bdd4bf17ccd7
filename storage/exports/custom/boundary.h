// ParseBoundary: the area that a map or an export is cut to, from GeoJSON (RFC 7946; also a Feature or
// FeatureCollection of polygons) and from KML (OGC 12-007; its polygons, of whatever placemark). Longitudes
// and latitudes of WGS 84. Pure; any thread. Errors: kInvalidArgument (neither of them, or a zip around one),
// kUnprocessable (no polygon, another coordinate system, too many corners).
#pragma once

#include <cstddef>
#include <string_view>

#include "core/base/result.h"
#include "core/geo/boundary.h"

namespace skyquilt::storage {

using geo::Boundary;
using geo::BoundaryOnZoom;
using geo::Cover;
using geo::kMaxBoundaryCorners;

inline constexpr std::size_t kMaxBoundaryBytes = std::size_t{16} << 20;  // of its file

Result<Boundary> ParseBoundary(std::string_view geojson);
// The same to be measured: kUnprocessable also where a ring crosses itself.
Result<Boundary> ParseArea(std::string_view geojson);
// GeoJSON or KML, whichever it is.
Result<Boundary> ParseBoundaryFile(std::string_view bytes);

}  // namespace skyquilt::storage
