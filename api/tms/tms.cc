#include "api/tms/tms.h"

#include <fmt/format.h>

#include "api/auth/flight_access.h"
#include "api/http/problem.h"
#include "api/ogc/map_view.h"
#include "api/tiles/tile_path.h"
#include "api/tiles/tiles.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

constexpr int kMaxMaps = 200;

Response Root(const Request& request) {
  return Xml(fmt::format(
      "<Services><TileMapService title=\"Skyquilt\" version=\"1.0.0\" href=\"{}/tms/1.0.0\"/></Services>\n",
      XmlText(request.base_url)));
}

Response Maps(Service& service, const Request& request) {
  const Result<storage::FlightPage> page = ListVisibleFlights(service, request, kMaxMaps, std::nullopt);
  if (!page) return Problem(page.error(), request);
  std::string maps;
  for (const storage::Flight& flight : page->flights) {
    if (!flight.active_revision) continue;
    maps +=
        fmt::format("<TileMap title=\"{}\" srs=\"EPSG:3857\" profile=\"none\" href=\"{}/tms/1.0.0/{}\"/>\n",
                    XmlText(flight.name), XmlText(request.base_url), flight.id);
  }
  return Xml(fmt::format(
      "<TileMapService version=\"1.0.0\"><Title>Skyquilt</Title><TileMaps>\n{}</TileMaps></TileMapService>\n",
      maps));
}

Response TileMap(Service& service, const Request& request) {
  const Result<MapView> map = FindMap(service, request, request.Parameter("flight"));
  if (!map) return Problem(map.error(), request);
  const auto [low, high] = geo::MercFromLatLonBounds(map->revision().bounds);
  std::string sets;
  // "order" counts from 0; the zoom is in the address.
  for (const TileMatrix& matrix : MatricesOf(*map)) {
    sets +=
        fmt::format("<TileSet href=\"{0}/tms/1.0.0/{1}/{2}\" units-per-pixel=\"{3:.15g}\" order=\"{2}\"/>\n",
                    XmlText(map->base_url), map->id, matrix.zoom, matrix.pixel_m);
  }
  return Xml(fmt::format(
      R"(<TileMap version="1.0.0" tilemapservice="{0}/tms/1.0.0/"><Title>{1}</Title><Abstract/><SRS>EPSG:3857</SRS>
<BoundingBox minx="{2:.9f}" miny="{3:.9f}" maxx="{4:.9f}" maxy="{5:.9f}"/><Origin x="-{6:.9f}" y="-{6:.9f}"/>
<TileFormat width="{7}" height="{7}" mime-type="image/png" extension="png"/>
<TileSets profile="none">
{8}</TileSets></TileMap>
)",
      XmlText(map->base_url), XmlText(map->name), low.x(), low.y(), high.x(), high.y(), geo::kMercHalfWidthM,
      map->tile_size_px(), sets));
}

Result<Response> TmsTile(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const TilePath path,
                      ParseTilePath(request.Parameter("z"), request.Parameter("x"), request.Parameter("y")));
  SKYQUILT_TRY_ASSIGN(const geo::TileId tile,
                      geo::TileId::Make(path.tile.z(), path.tile.x(), path.tile.TmsRow()));
  TileRequest wanted;
  wanted.flight_id = request.Parameter("flight");
  wanted.tile = tile;
  wanted.format = path.format;
  wanted.is_double = path.is_double;
  return AnswerTile(service, request, wanted);
}

}  // namespace

void AddTmsRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/tms", Root);
  router.Add(Method::kGet, "/tms/1.0.0", [&](const Request& r) { return Maps(service, r); });
  router.Add(Method::kGet, "/tms/1.0.0/{flight}", [&](const Request& r) { return TileMap(service, r); });
  router.AddQuick(Method::kGet, "/tms/1.0.0/{flight}/{z}/{x}/{y}",
                  [&](const Request& r) { return TileResponse(TmsTile(service, r), r); });
}

}  // namespace skyquilt::api
