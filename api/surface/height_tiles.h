// What tiles made of a map's heights share, whatever they show of them: PNG of kHeightTilePx a side, computed
// when they are asked for and kept as other made tiles are, and the TileJSON that names them. `variant`: what
// is made, for the tile's key and tag. Any thread. Errors: kInvalidArgument, kNotFound (no such map, no
// heights, no tiles of this zoom), and those of making one.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "api/http/router.h"
#include "api/service.h"
#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "storage/rasters/height_raster.h"

namespace skyquilt::api {

inline constexpr int kHeightTilePx = 256;
// In addresses: the heights themselves (api/surface/terrain.cc).
inline constexpr const char* kTerrainTiles = "terrain";

storage::MercGrid HeightTileGrid(const geo::TileId& tile);
// kNotFound where the zoom's pixels are smaller than the cells.
Result<void> CheckHeightZoom(const storage::HeightRaster& heights, const storage::Revision& revision,
                             const geo::TileId& tile);

using MakeHeightTile =
    std::function<Result<std::string>(const storage::Tileset&, Surface, const geo::TileId&)>;
Result<Response> AnswerHeightTile(Service& service, const Request& request, const std::string& variant,
                                  const MakeHeightTile& make);

// Adds what is particular, and answers what the tiles' addresses have besides.
using TellHeightTiles =
    std::function<Result<std::string>(const storage::Tileset&, Surface, nlohmann::ordered_json&)>;
Result<Response> AnswerHeightTileJson(Service& service, const Request& request, const char* tiles,
                                      const TellHeightTiles& tell);

// GET /tiles/{flight}/TILES.json and /tiles/{flight}/TILES/{z}/{x}/{y}.
using HeightTileHandler = Result<Response> (*)(Service&, const Request&);
void AddHeightTileRoutes(Router& router, Service& service, const char* tiles, HeightTileHandler tile,
                         HeightTileHandler tilejson);

}  // namespace skyquilt::api
