#include "api/surface/height_tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "api/http/links.h"
#include "api/http/responses.h"
#include "api/surface/map_surface.h"
#include "api/tiles/tile_answer.h"
#include "api/tiles/tile_json_place.h"
#include "api/tiles/tile_path.h"
#include "api/tiles/tiles.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

// The first zoom whose pixels are no larger than the cells.
int MaxHeightZoom(const storage::HeightRaster& heights, const storage::Revision& revision) {
  const double cell_merc_m =
      heights.cell_m() / geo::GroundMetresPerMercMetre(revision.bounds.Middle().lat_deg);
  int zoom = 0;
  while (zoom < geo::kMaxZoom && geo::PixelSizeInMercM(zoom, kHeightTilePx) > cell_merc_m) ++zoom;
  return zoom;
}

}  // namespace

storage::MercGrid HeightTileGrid(const geo::TileId& tile) {
  const geo::Bounds2 bounds = tile.BoundsInMerc();
  const double pixel_m = bounds.Width() / kHeightTilePx;
  return {bounds.min.x(), bounds.max.y(), pixel_m, pixel_m, kHeightTilePx, kHeightTilePx};
}

Result<void> CheckHeightZoom(const storage::HeightRaster& heights, const storage::Revision& revision,
                             const geo::TileId& tile) {
  if (tile.z() <= MaxHeightZoom(heights, revision)) return {};
  return Error{ErrorCode::kNotFound, "There are no tiles of this zoom: the heights have larger cells."};
}

Result<Response> AnswerHeightTile(Service& service, const Request& request, const std::string& variant,
                                  const MakeHeightTile& make) {
  SKYQUILT_TRY_ASSIGN(const TilePath path,
                      ParseTilePath(request.Parameter("z"), request.Parameter("x"), request.Parameter("y")));
  if (path.is_double || path.format.value_or(image::PictureFormat::kPng) != image::PictureFormat::kPng)
    return Error{ErrorCode::kInvalidArgument,
                 "These tiles are there as .png of one size: their colours are numbers."};
  SKYQUILT_TRY_ASSIGN(const Surface surface, SurfaceIn(request));
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset,
                      MapFor(service, request, flight_id));
  if (tileset == nullptr) return DeferTo(Work::kRead);
  storage::MadeTileKey key{flight_id, tileset->revision.revision, path.tile};
  key.look = fmt::format("{} {}", variant, NameOf(surface));
  return AnswerMade(service, request, *tileset, key, variant,
                    [&] { return make(*tileset, surface, path.tile); });
}

Result<Response> AnswerHeightTileJson(Service& service, const Request& request, const char* tiles,
                                      const TellHeightTiles& tell) {
  SKYQUILT_TRY_ASSIGN(const Surface surface, SurfaceIn(request));
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(flight_id));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset, service.tilesets.Get(flight_id));
  const storage::Revision& revision = tileset->revision;
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<storage::HeightRaster> heights,
                      service.surfaces.Open(flight_id, revision.revision, surface));
  const int max_zoom = MaxHeightZoom(*heights, revision);
  nlohmann::ordered_json json;
  json["tilejson"] = "3.0.0";
  json["name"] = fmt::format("{}, {}", flight.name, NameOf(surface));
  json["version"] = fmt::format("{}.0.0", revision.revision);
  json["scheme"] = "xyz";
  json["tiles"] = nlohmann::ordered_json::array();
  AddPlace(revision.bounds, std::max(0, max_zoom - 3), json);
  json["minzoom"] = 0;
  json["maxzoom"] = max_zoom;
  json["tileSize"] = kHeightTilePx;
  SKYQUILT_TRY_ASSIGN(const std::string besides, tell(*tileset, surface, json));
  json["tiles"].push_back(
      LinkTo(request, fmt::format("/tiles/{}/{}/{{z}}/{{x}}/{{y}}.png?rev={}&of={}{}", flight_id, tiles,
                                  revision.revision, NameOf(surface), besides)));
  return Tagged(request, NoCache(Text(200, JsonText(json), "application/json")));
}

void AddHeightTileRoutes(Router& router, Service& service, const char* tiles, HeightTileHandler tile,
                         HeightTileHandler tilejson) {
  router.AddCompute(Method::kGet, fmt::format("/tiles/{{flight}}/{}.json", tiles),
                    [&service, tilejson](const Request& request) { return tilejson(service, request); });
  router.AddQuick(Method::kGet, fmt::format("/tiles/{{flight}}/{}/{{z}}/{{x}}/{{y}}", tiles),
                  [&service, tile](const Request& request) { return tile(service, request); });
}

}  // namespace skyquilt::api
