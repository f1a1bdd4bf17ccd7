// ParseTilePath: z, x and "y.ext" or "y@2x.ext" of a tile's address, strictly: plain decimal digits, nothing
// before or behind. ParseTileNumbers: the same of a grid whose matrices are no squares, unchecked against it.
// Pure. Errors: kInvalidArgument (not a number, outside the zoom's square, an extension
// that is not a tile's).
#pragma once

#include <cstdint>
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

struct TileNumbers {
  std::int64_t z = 0, x = 0, y = 0;
  std::optional<image::PictureFormat> format;
  bool is_double = false;
};

Result<TileNumbers> ParseTileNumbers(std::string_view z, std::string_view x,
                                     std::string_view y_and_extension);
Result<TilePath> ParseTilePath(std::string_view z, std::string_view x, std::string_view y_and_extension);

}  // namespace skyquilt::api
