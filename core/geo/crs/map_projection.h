// MapProjection: a coordinate system of EPSG with two horizontal axes: from its coordinates to WGS84 and
// back, through PROJ. x is east or longitude, y north or latitude, in the system's own unit, whatever order
// its authority has them in. WGS84's UTM needs no look into PROJ's database. Const calls on one object by one
// thread at a time. Errors: kInvalidArgument (no such code, or no such system).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "core/base/result.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::geo {

class MapProjection {
 public:
  static Result<MapProjection> OfEpsg(int code);
  MapProjection(MapProjection&&) noexcept;
  MapProjection& operator=(MapProjection&&) noexcept;
  ~MapProjection();

  // Absent outside of what the system can say, also where PROJ answers with a place that lies elsewhere in
  // it.
  std::optional<LatLon> LatLonOf(const Eigen::Vector2d& place) const;
  std::optional<Eigen::Vector2d> PlaceOf(const LatLon& position) const;

  bool is_geographic() const;   // in degrees
  bool is_north_first() const;  // its authority says y before x

 private:
  struct Impl;
  explicit MapProjection(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace skyquilt::geo
