// Files that other programs open to show the map: a QGIS layer, JOSM imagery, a GDAL description, an ArcGIS
// web map.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/common/feature_query.h"
#include "api/http/responses.h"
#include "api/routes.h"
#include "api/views/map_view.h"
#include "api/wmts/wmts_text.h"
#include "core/base/text/json_io.h"
#include "core/base/text/percent.h"
#include "core/base/text/xml_text.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

// "{z}" and its kin as a program writes them. Without an ending: tiles come as they are stored, which costs
// neither the server nor the network anything; all of these programs look at the bytes.
std::string Tiles(const MapView& map, const char* z, const char* x, const char* y) {
  return map.Link(fmt::format("/tiles/{}/{}/{}/{}", map.id, z, x, y));
}

// WMTS, because QGIS takes every XYZ source to be as large as the world, and "Zoom to Layer" then shows
// nothing.
std::string QgisSource(const MapView& map) {
  const bool is_webp = storage::EncodingOf(map.tileset->reader->metadata()) == image::TileEncoding::kWebp;
  const std::string capabilities = map.Link("/wmts/" + map.id + "?SERVICE=WMTS&REQUEST=GetCapabilities");
  return fmt::format("crs=EPSG:3857&format={}&layers=map&styles=default&tileMatrixSet={}&url={}",
                     is_webp ? "image/webp" : kStoredTileType, MatrixSetName(map.tile_size_px()),
                     PercentEncoded(capabilities, "-._/:"));
}

std::string Qgis(const MapView& map) {
  const std::string source = QgisSource(map);
  const std::string id = "skyquilt_" + map.id;
  const geo::Bounds2 extent = geo::MercFromLatLonBounds(map.revision().bounds);
  return fmt::format(
      R"(<!DOCTYPE qgis-layer-definition>
<qlr>
  <layer-tree-group name="" checked="Qt::Checked" expanded="1">
    <layer-tree-layer id="{0}" name="{1}" source="{2}" providerKey="wms" checked="Qt::Checked" expanded="1"/>
  </layer-tree-group>
  <maplayers>
    <maplayer type="raster" hasScaleBasedVisibilityFlag="0">
      <id>{0}</id>
      <datasource>{2}</datasource>
      <extent><xmin>{3:.3f}</xmin><ymin>{4:.3f}</ymin><xmax>{5:.3f}</xmax><ymax>{6:.3f}</ymax></extent>
      <layername>{1}</layername>
      <provider>wms</provider>
      <srs><spatialrefsys><authid>EPSG:3857</authid></spatialrefsys></srs>
      <pipe><rasterrenderer type="singlebandcolordata" band="1" opacity="1"/></pipe>
    </maplayer>
  </maplayers>
</qlr>
)",
      id, XmlText(map.name), XmlText(source), extent.min.x(), extent.min.y(), extent.max.x(), extent.max.y());
}

std::string Josm(const MapView& map) {
  const auto [west, south, east, north] = GeoJsonBbox(map.revision().bounds);  // whose east may be west of it
  return fmt::format(
      R"(<imagery xmlns="http://josm.openstreetmap.de/maps-1.0">
  <entry>
    <name>{}</name>
    <id>skyquilt-{}</id>
    <type>tms</type>
    <url>{}</url>
    <min-zoom>{}</min-zoom>
    <max-zoom>{}</max-zoom>
    <tile-size>{}</tile-size>
    <bounds min-lat="{:.7f}" min-lon="{:.7f}" max-lat="{:.7f}" max-lon="{:.7f}"/>
  </entry>
</imagery>
)",
      XmlText(map.name), map.id, XmlText(Tiles(map, "{zoom}", "{x}", "{y}")), map.revision().min_zoom,
      map.revision().max_zoom, map.tile_size_px(), south, west, north, east);
}

// The window is the map's own, cut at the coarsest zoom's tiles, so that every zoom is an overview: the whole
// world at this resolution is beyond GDAL's counters.
std::string Gdal(const MapView& map) {
  const std::vector<TileMatrix> matrices = MatricesOf(map, map.tile_size_px());
  const TileMatrix& coarse = matrices.front();
  const int finest_zoom = matrices.back().zoom;
  const int overviews = finest_zoom - coarse.zoom;
  // Beyond the antimeridian columns go on, as tiles are answered there too (api/tiles).
  const geo::LatLonBounds& bounds = map.revision().bounds;
  const auto column_of = [&](double lon_deg) {
    const geo::LatLon corner{.lat_deg = bounds.south_deg, .lon_deg = lon_deg};
    return geo::TileId::AtMerc(coarse.zoom, geo::MercFromLatLon(corner)).x();
  };
  const std::uint32_t around = std::uint32_t{1} << coarse.zoom;
  const std::uint32_t west = column_of(bounds.west_deg);
  const std::uint32_t east = bounds.east_deg > 180.0
                                 ? std::min(around + column_of(bounds.east_deg - 360.0), west + around - 1)
                                 : column_of(bounds.east_deg);
  const double side_m = geo::TileSizeInMercM(coarse.zoom);
  const auto x = [&](std::uint64_t column) {
    return -geo::kMercHalfWidthM + static_cast<double>(column) * side_m;
  };
  const auto y = [&](std::uint64_t row) { return geo::kMercHalfWidthM - static_cast<double>(row) * side_m; };
  const auto pixels = [&](std::uint32_t first, std::uint32_t last) {
    return (std::uint64_t{last - first + 1} << overviews) * static_cast<std::uint64_t>(map.tile_size_px());
  };
  return fmt::format(
      R"(<GDAL_WMS>
  <Service name="TMS"><ServerUrl>{}</ServerUrl></Service>
  <DataWindow>
    <UpperLeftX>{:.9f}</UpperLeftX><UpperLeftY>{:.9f}</UpperLeftY>
    <LowerRightX>{:.9f}</LowerRightX><LowerRightY>{:.9f}</LowerRightY>
    <SizeX>{}</SizeX><SizeY>{}</SizeY>
    <TileLevel>{}</TileLevel><TileX>{}</TileX><TileY>{}</TileY><YOrigin>top</YOrigin>
  </DataWindow>
  <Projection>EPSG:3857</Projection>
  <BlockSizeX>{}</BlockSizeX><BlockSizeY>{}</BlockSizeY>
  <BandsCount>4</BandsCount>
  <OverviewCount>{}</OverviewCount>
  <ZeroBlockHttpCodes>204,404</ZeroBlockHttpCodes>
  <Cache/>
</GDAL_WMS>
)",
      XmlText(Tiles(map, "${z}", "${x}", "${y}")), x(west), y(coarse.min_row), x(east + 1),
      y(coarse.max_row + 1), pixels(west, east), pixels(coarse.min_row, coarse.max_row), finest_zoom,
      std::uint64_t{west} << overviews, std::uint64_t{coarse.min_row} << overviews, map.tile_size_px(),
      map.tile_size_px(), overviews);
}

std::string Arcgis(const MapView& map) {
  Value layer;
  layer["id"] = "skyquilt-" + map.id;
  layer["title"] = map.name;
  layer["layerType"] = "ArcGISTiledMapServiceLayer";
  layer["url"] = map.Link("/arcgis/rest/services/" + map.id + "/MapServer");
  layer["visibility"] = true;
  layer["opacity"] = 1;
  Value web_map;
  web_map["operationalLayers"] = Value::array({layer});
  web_map["baseMap"] = {{"title", "None"}, {"baseMapLayers", Value::array()}};
  web_map["spatialReference"] = {{"wkid", 102100}, {"latestWkid", 3857}};
  web_map["version"] = "2.25";
  return JsonText(web_map, 1) + "\n";
}

}  // namespace

void AddConnectRoutes(Router& router, Service& service) {
  const auto add = [&](const char* file, const char* type, std::string (*write)(const MapView&)) {
    router.Add(
        Method::kGet, std::string("/connect/{flight}/") + file,
        [&service, file, type, write](const Request& request) -> Result<Response> {
          SKYQUILT_TRY_ASSIGN(const MapView map, FindMap(service, request, request.Parameter("flight")));
          Response response = NoCache(Text(200, write(map), type));
          response.headers.Add("Content-Disposition", std::string("attachment; filename=\"") + file + "\"");
          return response;
        });
  };
  add("qgis.qlr", "application/x-qgis-layer-definition", Qgis);
  add("josm.xml", "application/xml", Josm);
  add("gdal.xml", "application/xml", Gdal);
  add("arcgis.json", "application/json", Arcgis);
}

}  // namespace skyquilt::api
