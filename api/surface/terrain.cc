#include "api/surface/terrain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "api/http/links.h"
#include "api/http/responses.h"
#include "api/surface/map_surface.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tile_answer.h"
#include "api/tiles/tile_path.h"
#include "api/tiles/tiles.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/render/map_layer.h"

namespace skyquilt::api {
namespace {

using TerrainJson = nlohmann::ordered_json;

// The first zoom whose pixels are no larger than the cells.
int MaxTerrainZoom(const storage::HeightRaster& heights, const storage::Revision& revision) {
  const double cell_merc_m =
      heights.cell_m() / geo::GroundMetresPerMercMetre(revision.bounds.Middle().lat_deg);
  int zoom = 0;
  while (zoom < geo::kMaxZoom && geo::PixelSizeInMercM(zoom, kTerrainTilePx) > cell_merc_m) ++zoom;
  return zoom;
}

Result<std::string> MakeTerrainTile(storage::HeightRaster& heights, const geo::TileId& tile) {
  const geo::Bounds2 bounds = tile.BoundsInMerc();
  const double pixel_m = bounds.Width() / kTerrainTilePx;
  SKYQUILT_TRY_ASSIGN(const std::vector<float> heights_m,
                      heights.GoingOnOver({bounds.min.x(), bounds.max.y(), pixel_m, pixel_m, kTerrainTilePx,
                                           kTerrainTilePx}));
  image::RgbaImage picture = image::RgbaImage::Transparent(kTerrainTilePx, kTerrainTilePx);
  for (std::size_t i = 0; i < heights_m.size(); ++i) {
    const render::Rgb colour = render::HeightColour(heights_m[i]);
    std::copy(colour.begin(), colour.end(), picture.rgba.begin() + static_cast<std::ptrdiff_t>(4 * i));
    picture.rgba[4 * i + 3] = 255;
  }
  return EncodeTile(std::move(picture), image::PictureFormat::kPng);
}

Result<Response> TerrainTile(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const TilePath path,
                      ParseTilePath(request.Parameter("z"), request.Parameter("x"), request.Parameter("y")));
  if (path.is_double || path.format.value_or(image::PictureFormat::kPng) != image::PictureFormat::kPng)
    return Error{ErrorCode::kInvalidArgument,
                 "Terrain is there as .png of one size: its colours are heights.", ""};
  SKYQUILT_TRY_ASSIGN(const Surface surface, SurfaceIn(request));
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset,
                      MapFor(service, request, flight_id));
  if (tileset == nullptr) return DeferTo(Work::kRead);
  storage::MadeTileKey key{flight_id, tileset->revision.revision, path.tile};
  key.look = fmt::format("{} {}", kTerrainTiles, NameOf(surface));
  SKYQUILT_TRY_ASSIGN(const auto made, Made(service, request, key, [&]() -> Result<std::string> {
                        SKYQUILT_TRY_ASSIGN(
                            const std::shared_ptr<storage::HeightRaster> heights,
                            OpenSurface(service, flight_id, tileset->revision.revision, surface));
                        if (path.tile.z() > MaxTerrainZoom(*heights, tileset->revision))
                          return Error{ErrorCode::kNotFound, "The terrain has no tiles of this zoom.", ""};
                        return MakeTerrainTile(*heights, path.tile);
                      }));
  if (made == nullptr) return DeferTo(Work::kCompute);
  return AnswerMade(request, *tileset, *made, image::PictureFormat::kPng, kTerrainTiles);
}

Result<Response> TerrainTileJson(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const Surface surface, SurfaceIn(request));
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(flight_id));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset, service.tilesets.Get(flight_id));
  const storage::Revision& revision = tileset->revision;
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<storage::HeightRaster> heights,
                      OpenSurface(service, flight_id, revision.revision, surface));
  const geo::LatLon middle = revision.bounds.Middle();
  const int max_zoom = MaxTerrainZoom(*heights, revision);
  TerrainJson json;
  json["tilejson"] = "3.0.0";
  json["name"] = fmt::format("{}, {}", flight.name, NameOf(surface));
  json["version"] = fmt::format("{}.0.0", revision.revision);
  json["scheme"] = "xyz";
  json["tiles"] = {LinkTo(request, fmt::format("/tiles/{}/{}/{{z}}/{{x}}/{{y}}.png?rev={}&of={}", flight_id,
                                               kTerrainTiles, revision.revision, NameOf(surface)))};
  json["bounds"] = revision.bounds.ToArray();
  json["center"] = {middle.lon_deg, middle.lat_deg, std::max(0, max_zoom - 3)};
  json["minzoom"] = 0;
  json["maxzoom"] = max_zoom;
  json["tileSize"] = kTerrainTilePx;
  json["encoding"] = "terrarium";
  Response response = Text(200, JsonText(json), "application/json");
  response.headers.Add("Cache-Control", "no-cache");
  return Tagged(request, std::move(response));
}

}  // namespace

void AddTerrainRoutes(Router& router, Service& service) {
  router.AddCompute(Method::kGet, fmt::format("/tiles/{{flight}}/{}.json", kTerrainTiles),
                    [&](const Request& request) { return TerrainTileJson(service, request); });
  router.AddQuick(Method::kGet, fmt::format("/tiles/{{flight}}/{}/{{z}}/{{x}}/{{y}}", kTerrainTiles),
                  [&](const Request& request) { return TerrainTile(service, request); });
}

}  // namespace skyquilt::api
