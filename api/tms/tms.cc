// TMS 1.0.0 (OSGeo's Tile Map Service): rows counted from the south.
// https://wiki.osgeo.org/wiki/Tile_Map_Service_Specification
#include <fmt/format.h>

#include "api/http/links.h"
#include "api/http/responses.h"
#include "api/routes.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tile_path.h"
#include "api/tiles/tiles.h"
#include "api/views/listed_maps.h"
#include "api/views/map_view.h"
#include "core/base/text/xml_text.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"

namespace skyquilt::api {
namespace {

Response Root(const Request& request) {
  return Xml(
      fmt::format("<Services><TileMapService title=\"Skyquilt\" version=\"1.0.0\" href=\"{}\"/></Services>\n",
                  XmlText(LinkTo(request, "/tms/1.0.0"))));
}

// Maps of larger tiles have those of 256 pixels where programs look first.
std::string PathOf(const std::string& flight_id, int stored_size_px, int side_px) {
  const bool is_first = side_px == TileSizesOf(stored_size_px).front();
  return fmt::format("/tms/1.0.0/{}{}", flight_id, is_first ? "" : fmt::format("/{}", side_px));
}

std::string TitleOf(const std::string& name, int stored_size_px, int side_px) {
  const bool is_first = side_px == TileSizesOf(stored_size_px).front();
  return is_first ? name : fmt::format("{}, {} pixels", name, side_px);
}

Result<Response> Maps(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const ListedMaps listed, ListMapsOf(service, request));
  std::string maps;
  for (const ListedMap& map : listed.maps) {
    const int stored_px = map.tiles.side_px;
    for (const int side_px : TileSizesOf(stored_px)) {
      maps += fmt::format("<TileMap title=\"{}\" srs=\"EPSG:3857\" profile=\"none\" href=\"{}\"/>\n",
                          XmlText(TitleOf(map.shown.name, stored_px, side_px)),
                          XmlText(listed.Link(PathOf(map.shown.flight_id, stored_px, side_px))));
    }
  }
  return Xml(
      fmt::format("<TileMapService version=\"1.0.0\"><Title>Skyquilt</Title><Abstract>{}</Abstract>"
                  "<TileMaps>\n{}</TileMaps></TileMapService>\n",
                  XmlText(listed.Note()), maps));
}

// The whole world, and every zoom from 0 on: programs number tiles from the box and tilesets from the first
// one (GDAL refuses others). What is coarser than the map, or beside it, is empty.
std::string TileMapText(const MapView& map, int side_px) {
  const std::string path = map.base_url + PathOf(map.id, map.tile_size_px(), side_px);
  std::string sets;
  for (int zoom = 0; zoom <= MatricesOf(map, side_px).back().zoom; ++zoom) {
    sets += fmt::format("<TileSet href=\"{0}/{1}\" units-per-pixel=\"{2:.15g}\" order=\"{1}\"/>\n",
                        XmlText(path), zoom, geo::PixelSizeInMercM(zoom, side_px));
  }
  // An address is put together of href, column, row and extension: only behind the last a token is where
  // it belongs.
  const std::string extension = map.token.empty() ? "png" : "png?" + map.token;
  return fmt::format(
      R"(<TileMap version="1.0.0" tilemapservice="{0}"><Title>{1}</Title><Abstract/><SRS>EPSG:3857</SRS>
<BoundingBox minx="-{2:.9f}" miny="-{2:.9f}" maxx="{2:.9f}" maxy="{2:.9f}"/><Origin x="-{2:.9f}" y="-{2:.9f}"/>
<TileFormat width="{3}" height="{3}" mime-type="image/png" extension="{4}"/>
<TileSets profile="none">
{5}</TileSets></TileMap>
)",
      XmlText(map.Link("/tms/1.0.0")), XmlText(TitleOf(map.name, map.tile_size_px(), side_px)),
      geo::kMercHalfWidthM, side_px, XmlText(extension), sets);
}

Result<Response> TileMap(Service& service, const Request& request, const std::string& size) {
  SKYQUILT_TRY_ASSIGN(const MapView map, FindMap(service, request, request.Parameter("flight")));
  for (const int side_px : map.tile_sizes_px()) {
    if (size.empty() || size == std::to_string(side_px)) return Xml(TileMapText(map, side_px));
  }
  return Error{ErrorCode::kNotFound,
               "This map has no tiles of this size. See " + request.base_url + "/tms/1.0.0."};
}

// "512" and its kin: the sides that tiles may have. Absent: any other text.
std::optional<int> ParseTileSide(std::string_view text) {
  for (int side_px = kUsualTilePx; side_px <= image::kMaxPictureSidePx; side_px *= 2) {
    if (text == std::to_string(side_px)) return side_px;
  }
  return std::nullopt;
}

Result<Response> TmsTile(Service& service, const Request& request, const std::string& size) {
  SKYQUILT_TRY_ASSIGN(const TilePath path,
                      ParseTilePath(request.Parameter("z"), request.Parameter("x"), request.Parameter("y")));
  SKYQUILT_TRY_ASSIGN(const geo::TileId tile,
                      geo::TileId::Make(path.tile.z(), path.tile.x(), path.tile.TmsRow()));
  TileRequest wanted;
  wanted.side_px = size.empty() ? kUsualTilePx : ParseTileSide(size);
  if (!wanted.side_px) {
    return Error{ErrorCode::kNotFound,
                 "There are no tiles of this size. See " + request.base_url + "/tms/1.0.0."};
  }
  wanted.flight_id = request.Parameter("flight");
  wanted.tile = tile;
  wanted.format = path.format;
  wanted.is_double = path.is_double;
  wanted.is_of_world = true;
  return AnswerTile(service, request, wanted);
}

}  // namespace

void AddTmsRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/tms", Root);
  router.Add(Method::kGet, "/tms/1.0.0", On(service, Maps));
  router.Add(Method::kGet, "/tms/1.0.0/{flight}", [&](const Request& r) { return TileMap(service, r, ""); });
  router.Add(Method::kGet, "/tms/1.0.0/{flight}/{size}",
             [&](const Request& r) { return TileMap(service, r, r.Parameter("size")); });
  router.AddQuick(Method::kGet, "/tms/1.0.0/{flight}/{z}/{x}/{y}",
                  [&](const Request& r) { return TmsTile(service, r, ""); });
  router.AddQuick(Method::kGet, "/tms/1.0.0/{flight}/{size}/{z}/{x}/{y}",
                  [&](const Request& r) { return TmsTile(service, r, r.Parameter("size")); });
}

}  // namespace skyquilt::api
