// LatLonBounds: the rectangle of latitudes and longitudes that something covers on WGS 84, in degrees. Across
// the antimeridian `east_deg` goes on beyond 180, while `west_deg` stays within -180 and 180 (OnEarth). A
// value; any thread.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

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

  // The same rectangle by whole turns, with its west edge in -180..180.
  LatLonBounds OnEarth() const {
    constexpr double kRoundingDeg = 1e-9;  // what the west edge of the whole Earth may be off by
    const bool is_beyond = west_deg < -180.0 - kRoundingDeg || west_deg > 180.0;
    LatLonBounds turned = is_beyond ? Turned(-360.0 * std::floor((west_deg + 180.0) / 360.0)) : *this;
    turned.west_deg = std::max(turned.west_deg, -180.0);
    return turned;
  }
  // For whoever knows no box across the antimeridian: all the way around the Earth where this one is.
  LatLonBounds AroundWhereAcross() const {
    constexpr double kRoundingDeg = 1e-9;
    if (east_deg > 180.0 + kRoundingDeg) return {-180.0, south_deg, 180.0, north_deg};
    return {west_deg, south_deg, std::min(east_deg, 180.0), north_deg};
  }
  // The same rectangle by whole turns, so that it lies next to `other` as their numbers go.
  LatLonBounds Beside(const LatLonBounds& other) const {
    return Turned(360.0 * std::round((other.Middle().lon_deg - Middle().lon_deg) / 360.0));
  }

  // Both as their numbers go: what may lie a turn off is put Beside first.
  void Include(const LatLonBounds& other) {
    west_deg = std::min(west_deg, other.west_deg);
    south_deg = std::min(south_deg, other.south_deg);
    east_deg = std::max(east_deg, other.east_deg);
    north_deg = std::max(north_deg, other.north_deg);
  }
  bool operator==(const LatLonBounds&) const = default;

 private:
  LatLonBounds Turned(double by_deg) const {
    return {west_deg + by_deg, south_deg, east_deg + by_deg, north_deg};
  }
};

}  // namespace skyquilt::geo
