// AnswerGridTile: a tile of a map in a grid that its own tiles do not lie in, resampled from them by what
// draws windows, and kept in memory like every made tile. JPEG where it is opaque throughout and PNG
// elsewhere (WebP of maps of WebP), unless a format is asked for. Any thread; made where processor time is
// fine. Errors: kNotFound (a level or a tile beside the map), kInvalidArgument (beside the grid), and those
// of reading maps.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "api/common/index_look.h"
#include "api/grids/map_grid.h"
#include "api/tiles/tiles.h"

namespace skyquilt::api {

struct GridTileRequest {
  std::string flight_id;
  MapGrid grid;  // one of the map's
  std::int64_t level = 0, column = 0, row = 0;
  std::optional<image::PictureFormat> format = {};  // absent: as above
  EmptyTile empty = EmptyTile::kBlank;
  std::optional<IndexLook> look = {};  // an index in colours; absent: the map as it is
  bool is_of_any_level = false;        // also of those that are none of the map's
};
Result<Response> AnswerGridTile(Service& service, const Request& request, const GridTileRequest& wanted);

// Error: kInvalidArgument, with what there is.
Result<void> CheckInGrid(const MapGrid& grid, std::int64_t level, std::int64_t column, std::int64_t row);
// Of the middle of a pixel of a tile. Error: kInvalidArgument beside the grid, kNotFound where it shows no
// place on Earth.
Result<geo::LatLon> PositionInGrid(const MapGrid& grid, std::int64_t level, std::int64_t column,
                                   std::int64_t row, const Eigen::Vector2d& pixel);

}  // namespace skyquilt::api
