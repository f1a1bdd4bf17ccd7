// LatLonBounds: the rectangle of latitudes and longitudes that something covers on WGS 84, in degrees. Across
// the antimeridian `east_deg` goes on beyond 180. A value; any thread.
#pragma once

#include <algorithm>
#include <array>

#include "core/geo/bounds.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::geo {

struct LatLonBounds {
  double west_deg = 0.0, south_deg = 0.0, east_deg = 0.0, north_deg = 0.0;

  // In the order of a bounding box in GeoJSON (RFC 7946, section 5), and of the columns of the catalogue.
  static LatLonBounds FromArray(const std::array<double, 4>& box) { return {box[0], box[1], box[2], box[3]}; }
  std::array<double, 4> ToArray() const { return {west_deg, south_deg, east_deg, north_deg}; }

  LatLon SouthWest() const { return {.lat_deg = south_deg, .lon_deg = west_deg}; }
  LatLon NorthEast() const { return {.lat_deg = north_deg, .lon_deg = east_deg}; }
  LatLon NorthWest() const { return {.lat_deg = north_deg, .lon_deg = west_deg}; }
  LatLon SouthEast() const { return {.lat_deg = south_deg, .lon_deg = east_deg}; }
  LatLon Middle() const {
    return {.lat_deg = 0.5 * (south_deg + north_deg), .lon_deg = 0.5 * (west_deg + east_deg)};
  }

  void Include(const LatLonBounds& other) {
    west_deg = std::min(west_deg, other.west_deg);
    south_deg = std::min(south_deg, other.south_deg);
    east_deg = std::max(east_deg, other.east_deg);
    north_deg = std::max(north_deg, other.north_deg);
  }
  bool operator==(const LatLonBounds&) const = default;
};

}  // namespace skyquilt::geo
