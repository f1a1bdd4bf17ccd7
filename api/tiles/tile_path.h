// ParseTilePath: z, x and "y.ext" or "y@2x.ext" of a tile's address, strictly: plain decimal digits, nothing
// before or behind. Pure. Errors: kInvalidArgument (not a number, outside the zoom's square, an extension
// that is not a tile's).
#pragma once

#include <optional>
#include <string_view>

#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "core/image/picture_format.h"

namespace skyquilt::api {

struct TilePath {
  geo::TileId tile;
  std::optional<image::PictureFormat> format;  // absent: as stored
  bool is_double = false;                      // "@2x"
};

Result<TilePath> ParseTilePath(std::string_view z, std::string_view x, std::string_view y_and_extension);

}  // namespace skyquilt::api
