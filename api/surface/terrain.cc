// Terrain tiles of a map's heights, for views in three dimensions and hillshades: PNG in "terrarium" coding
// (core/render/map_layer.h), computed when they are asked for and kept as other made tiles are. There is one
// for every tile of the Earth: beyond the map its height goes on. GET /tiles/{flight}/terrain.json and
// /tiles/{flight}/terrain/{z}/{x}/{y}. Any thread.

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "api/routes.h"
#include "api/surface/height_tiles.h"
#include "api/surface/map_surface.h"
#include "api/tiles/recode_tile.h"
#include "core/base/try.h"
#include "core/render/map_layer.h"

namespace skyquilt::api {
namespace {

Result<std::string> MakeTerrainTile(storage::HeightRaster& heights, const geo::TileId& tile) {
  SKYQUILT_TRY_ASSIGN(const std::vector<float> heights_m, heights.GoingOnOver(HeightTileGrid(tile)));
  image::RgbaImage picture = image::RgbaImage::Transparent(kHeightTilePx, kHeightTilePx);
  for (std::size_t i = 0; i < heights_m.size(); ++i) {
    const render::Rgb colour = render::HeightColour(heights_m[i]);
    std::copy(colour.begin(), colour.end(), picture.rgba.begin() + static_cast<std::ptrdiff_t>(4 * i));
    picture.rgba[4 * i + 3] = 255;
  }
  return EncodeTile(std::move(picture), image::PictureFormat::kPng);
}

Result<Response> TerrainTile(Service& service, const Request& request) {
  return AnswerHeightTile(
      service, request, kTerrainTiles,
      [&](const storage::Tileset& shown, Surface surface, const geo::TileId& tile) -> Result<std::string> {
        SKYQUILT_TRY_ASSIGN(const std::shared_ptr<storage::HeightRaster> heights,
                            service.surfaces.Open(shown.flight_id, shown.revision.revision, surface));
        SKYQUILT_TRY(CheckHeightZoom(*heights, shown.revision, tile));
        return MakeTerrainTile(*heights, tile);
      });
}

Result<Response> TerrainTileJson(Service& service, const Request& request) {
  return AnswerHeightTileJson(service, request, kTerrainTiles,
                              [](const storage::Tileset&, Surface, nlohmann::ordered_json& json) {
                                json["encoding"] = "terrarium";
                                return Result<std::string>("");
                              });
}

}  // namespace

void AddTerrainRoutes(Router& router, Service& service) {
  AddHeightTileRoutes(router, service, kTerrainTiles, TerrainTile, TerrainTileJson);
}

}  // namespace skyquilt::api
