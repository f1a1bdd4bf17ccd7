// What a map shows at one place: its colour, the height of the ground, the photo that it comes from, and the
// value of an index. Any
// thread; reads the cameras of the whole flight, so where processor time is fine. Errors: kInvalidArgument
// (no place), kNotFound (no such flight, or no map yet), kCorrupt, kIo.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "api/common/index_look.h"
#include "api/service.h"
#include "core/geo/lat_lon.h"
#include "core/pipeline/report/locate.h"

namespace skyquilt::api {

struct MapPoint {
  std::string flight_id;
  std::string flight_name;
  std::int64_t revision = 0;
  geo::LatLon position;
  std::optional<std::array<std::uint8_t, 4>> rgba;  // of the finest pixel there; absent: the map has nothing
  std::optional<double> height_m;                   // counted from the zero that the flight's heights have
  // The photo that the pixel came from; without the layer that says so, the one that sees the place most
  // nearly from above.
  std::optional<pipeline::Sighting> photo;
  bool is_photo_of_pixel = false;
  std::optional<double> index_value;  // of the index that was asked for; absent: none was, or it has no value
};

// `with_ground`: height and photo too, which take longer than all else.
Result<MapPoint> LookAt(Service& service, const std::string& flight_id, const geo::LatLon& position,
                        const std::optional<IndexLook>& look = std::nullopt, bool with_ground = true);

}  // namespace skyquilt::api
