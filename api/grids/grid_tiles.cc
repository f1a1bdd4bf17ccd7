#include "api/grids/grid_tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "api/http/responses.h"
#include "api/tiles/index_values.h"
#include "api/tiles/map_window.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tile_answer.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

Result<void> CheckOnMap(const storage::Tileset& tileset, const GridTileRequest& wanted) {
  const std::vector<GridMatrix> matrices = MatricesOf(wanted.grid, tileset.revision, TileSizePx(tileset));
  const auto found = std::find_if(matrices.begin(), matrices.end(),
                                  [&](const GridMatrix& matrix) { return matrix.level == wanted.level; });
  if (found == matrices.end() && wanted.is_of_any_level) return {};
  if (found == matrices.end()) return Error{ErrorCode::kNotFound, "The map has no tiles of this level."};
  if (wanted.column < found->min_column || wanted.column > found->max_column || wanted.row < found->min_row ||
      wanted.row > found->max_row) {
    return Error{ErrorCode::kNotFound, "This tile lies outside the map."};
  }
  return {};
}

Result<image::RgbaImage> DrawGridTile(Service& service, const storage::Tileset& tileset,
                                      const GridTileRequest& wanted) {
  SKYQUILT_TRY_ASSIGN(const MapCrs crs, wanted.grid.Crs());
  const geo::Bounds2 box = wanted.grid.BoundsOf(static_cast<int>(wanted.level), wanted.column, wanted.row);
  const MapWindow window =
      WindowOf(crs, box, MapGrid::kTilePx, MapGrid::kTilePx, tileset.revision.bounds.Middle());
  if (!wanted.look) return RenderWindow(tileset, window);
  SKYQUILT_TRY_ASSIGN(const IndexValues values,
                      ValuesOfWindow(service.bands, tileset, wanted.look->expression, window));
  return Coloured(values, *wanted.look);
}

image::PictureFormat UsualFormat(const storage::Tileset& tileset, bool is_opaque) {
  if (storage::EncodingOf(tileset.reader->metadata()) == image::TileEncoding::kWebp)
    return image::PictureFormat::kWebp;
  return is_opaque ? image::PictureFormat::kJpeg : image::PictureFormat::kPng;
}

// Empty: nothing can be seen of it.
Result<std::string> MakeGridTile(Service& service, const storage::Tileset& tileset,
                                 const GridTileRequest& wanted) {
  SKYQUILT_TRY_ASSIGN(image::RgbaImage picture, DrawGridTile(service, tileset, wanted));
  std::uint8_t least = 255, most = 0;
  for (std::size_t i = 3; i < picture.rgba.size(); i += 4) {
    least = std::min(least, picture.rgba[i]);
    most = std::max(most, picture.rgba[i]);
  }
  if (most == 0) return std::string();
  const image::PictureFormat format = wanted.format.value_or(UsualFormat(tileset, least == 255));
  return EncodeTile(std::move(picture), format);
}

}  // namespace

Result<void> CheckInGrid(const MapGrid& grid, std::int64_t level, std::int64_t column, std::int64_t row) {
  if (level < grid.first_level() || level > grid.last_level()) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} has levels {} to {}.", grid.name(), grid.first_level(), grid.last_level())};
  }
  const std::int64_t columns = grid.Columns(static_cast<int>(level)),
                     rows = grid.Rows(static_cast<int>(level));
  if (column < 0 || column >= columns || row < 0 || row >= rows) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("Level {} of {} has columns 0 to {} and rows 0 to {}.", level, grid.name(),
                             columns - 1, rows - 1)};
  }
  return {};
}

Result<Response> AnswerGridTile(Service& service, const Request& request, const GridTileRequest& wanted) {
  SKYQUILT_TRY(CheckId(wanted.flight_id, "flight"));
  SKYQUILT_TRY(CheckInGrid(wanted.grid, wanted.level, wanted.column, wanted.row));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset,
                      MapFor(service, request, wanted.flight_id));
  if (tileset == nullptr) return DeferTo(Work::kRead);
  SKYQUILT_TRY(CheckOnMap(*tileset, wanted));
  storage::MadeTileKey key;
  key.flight_id = tileset->flight_id;
  key.revision = tileset->revision.revision;
  key.format = wanted.format.value_or(image::PictureFormat::kPng);
  if (wanted.look) key.look = wanted.look->Query();
  key.grid = fmt::format("{}/{}/{}/{}{}", wanted.grid.name(), wanted.level, wanted.row, wanted.column,
                         wanted.format ? "" : "/usual");
  return AnswerMade(
      service, request, *tileset, key, "grid", [&] { return MakeGridTile(service, *tileset, wanted); },
      wanted.empty, MapGrid::kTilePx);
}

Result<geo::LatLon> PositionInGrid(const MapGrid& grid, std::int64_t level, std::int64_t column,
                                   std::int64_t row, const Eigen::Vector2d& pixel) {
  SKYQUILT_TRY(CheckInGrid(grid, level, column, row));
  SKYQUILT_TRY_ASSIGN(const MapCrs crs, grid.Crs());
  const geo::Bounds2 box = grid.BoundsOf(static_cast<int>(level), column, row);
  const double cell = grid.CellSize(static_cast<int>(level));
  const std::optional<geo::LatLon> position =
      crs.LatLonOf({box.min.x() + (pixel.x() + 0.5) * cell, box.max.y() - (pixel.y() + 0.5) * cell});
  if (!position) return Error{ErrorCode::kNotFound, "This pixel shows no place on Earth."};
  return *position;
}

}  // namespace skyquilt::api
