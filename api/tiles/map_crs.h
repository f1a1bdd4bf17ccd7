// MapCrs: a coordinate system in which a map is drawn: Web Mercator, longitude and latitude, or any of EPSG
// that is a map projection; and what a window or a box in it is. Coordinates are x (east, longitude) and y
// (north, latitude), whatever order the authority has; is_north_first says it. A value that shares what it
// computes with: one thread at a time. Errors: kInvalidArgument; the message says what there is.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "api/tiles/map_window.h"
#include "core/geo/bounds.h"
#include "core/geo/crs/map_projection.h"
#include "core/geo/lat_lon_bounds.h"

namespace skyquilt::api {

class MapCrs {
 public:
  static MapCrs Mercator();  // EPSG:3857
  static MapCrs Crs84();     // longitude before latitude
  static Result<MapCrs> OfEpsg(int code);
  // By its URI ("http://www.opengis.net/def/crs/EPSG/0/3857"), as a CURIE ("[EPSG:3857]", also without the
  // brackets) or as a URN.
  static Result<MapCrs> Named(std::string_view text);

  std::string uri() const;
  bool is_crs84() const { return epsg_ == 0; }
  bool is_north_first() const { return is_north_first_; }
  bool is_in_degrees() const;
  // Absent where the system has no such place.
  std::optional<geo::LatLon> LatLonOf(const Eigen::Vector2d& place) const;
  std::optional<Eigen::Vector2d> PlaceOf(const geo::LatLon& position) const;
  // How many metres of ground one unit of x and of y are at a place. Absent where they cannot be told.
  std::optional<Eigen::Vector2d> MetresPerUnit(const Eigen::Vector2d& place) const;

  bool operator==(const MapCrs& other) const { return epsg_ == other.epsg_; }

 private:
  friend MapWindow WindowOf(const MapCrs& crs, const geo::Bounds2& box, int width_px, int height_px,
                            const geo::LatLon& near);
  enum class Kind : std::uint8_t { kMercator, kDegrees, kProjected };
  MapCrs(Kind kind, int epsg) : kind_(kind), epsg_(epsg) {}

  Kind kind_;
  int epsg_;  // 0: CRS84
  bool is_north_first_ = false;
  std::shared_ptr<const geo::MapProjection> projection_;  // of kProjected
};

// The window that shows a box in so many pixels. `near`: where the map is, which decides how fine it is read.
MapWindow WindowOf(const MapCrs& crs, const geo::Bounds2& box, int width_px, int height_px,
                   const geo::LatLon& near);
// What holds a box of one system in another, its sides followed. Absent: nothing of it has a place there.
std::optional<geo::Bounds2> BoxIn(const MapCrs& to, const geo::Bounds2& box, const MapCrs& from);
std::optional<geo::Bounds2> BoxIn(const MapCrs& to, const geo::LatLonBounds& bounds);

}  // namespace skyquilt::api
