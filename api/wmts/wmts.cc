// WMTS 1.0.0, both bindings: of one map at /wmts/{flight}, with the layer "map", and at /wmts of all maps
// that a request may read, each a layer by the flight's id. OGC 07-057r7.
#include <fmt/format.h>

#include <variant>

#include "api/flights/point.h"
#include "api/grids/grid_tiles.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/routes.h"
#include "api/tiles/tile_answer.h"
#include "api/tiles/tile_path.h"
#include "api/tiles/tiles.h"
#include "api/views/feature_info.h"
#include "api/views/listed_maps.h"
#include "api/views/map_view.h"
#include "api/wmts/wmts_text.h"
#include "core/base/text/xml_text.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_format.h"

namespace skyquilt::api {
namespace {

constexpr const char* kLayer = "map";  // of the service of one map

// OWS has its own words for what is wrong.
Response Exception(int status, const char* code, std::string_view locator, std::string_view text) {
  Response response = Xml(fmt::format(
      R"(<ows:ExceptionReport xmlns:ows="http://www.opengis.net/ows/1.1" version="1.0.0">
  <ows:Exception exceptionCode="{}" locator="{}"><ows:ExceptionText>{}</ows:ExceptionText></ows:Exception>
</ows:ExceptionReport>
)",
      code, XmlText(locator), XmlText(text)));
  response.status = status;
  return response;
}

Response Exception(const Error& error) {
  const int status = StatusOf(error.code);
  const char* code = status == 404 ? "NotFound" : status < 500 ? "InvalidParameterValue" : "NoApplicableCode";
  return Exception(status, code, "", error.message);
}

Response AnswerCapabilities(Service& service, const Request& request) {
  const Result<ListedMaps> listed = ListMapsOf(service, request);
  return listed ? Xml(WmtsCapabilities(*listed)) : Exception(listed.error());
}

// What an address has behind the column for tiles of this type.
std::optional<std::string> EndingOfType(std::string_view type) {
  for (const image::PictureFormatRow& row : image::kPictureFormats) {
    if (type == row.content_type) return std::string(".") + row.extension;
  }
  if (type == kStoredTileType) return "";
  return std::nullopt;
}

Response AnswerTileAt(Service& service, const Request& request, const std::string& flight_id,
                      const MapSet& set, const std::string& style, std::string_view matrix,
                      std::string_view row, std::string_view column_and_ending, bool is_of_any_zoom) {
  // Column and row stand the other way round in our own addresses.
  const std::size_t dot = column_and_ending.find('.');
  std::string y(row);
  if (dot != std::string_view::npos) y += column_and_ending.substr(dot);
  const std::string_view column = column_and_ending.substr(0, dot);
  Result<std::optional<IndexLook>> look = LookOfStyle(style);
  if (!look) return Exception(400, "InvalidParameterValue", "Style", look.error().message);
  if (set.grid) {
    const Result<TileNumbers> numbers = ParseTileNumbers(matrix, column, y);
    if (!numbers) return Exception(400, "TileOutOfRange", "TileRow", numbers.error().message);
    const Result<void> is_in_grid = CheckInGrid(*set.grid, numbers->z, numbers->x, numbers->y);
    if (!is_in_grid) return Exception(400, "TileOutOfRange", "TileRow", is_in_grid.error().message);
    GridTileRequest wanted{flight_id, *set.grid, numbers->z, numbers->x, numbers->y, numbers->format};
    wanted.look = *std::move(look);
    wanted.is_of_any_level = is_of_any_zoom;
    Result<Response> answer = AnswerGridTile(service, request, wanted);
    return answer ? *std::move(answer) : Exception(answer.error());
  }
  const Result<TilePath> path = ParseTilePath(matrix, column, y);
  if (!path) return Exception(400, "TileOutOfRange", "TileRow", path.error().message);
  TileRequest wanted;
  wanted.flight_id = flight_id;
  wanted.tile = path->tile;
  wanted.format = path->format;
  wanted.side_px = set.side_px;
  wanted.look = *std::move(look);
  wanted.is_of_any_zoom = is_of_any_zoom;
  Result<Response> answer = AnswerTile(service, request, wanted);
  if (!answer) return Exception(answer.error());
  return *std::move(answer);
}

// "1" and "EPSG:3857:1" alike: some clients put the set before the matrix.
std::string_view MatrixName(std::string_view text) { return text.substr(text.rfind(':') + 1); }

// What both operations of a tile are about.
struct WmtsTile {
  std::string flight_id;
  MapSet set;
  std::string style, matrix, row, column, ending;
};
std::variant<WmtsTile, Response> ParseKvpTile(Service& service, const Request& request) {
  for (const char* name : {"Layer", "Format", "TileMatrixSet", "TileMatrix", "TileRow", "TileCol"}) {
    if (!Parameter(request, name))
      return Exception(400, "MissingParameterValue", name, "This parameter is missing.");
  }
  const Result<std::string> flight_id = FlightOfLayer(request, *Parameter(request, "Layer"));
  if (!flight_id) return Exception(400, "InvalidParameterValue", "Layer", flight_id.error().message);
  const std::string style = Parameter(request, "Style").value_or("default");
  const std::optional<std::string> ending = EndingOfType(*Parameter(request, "Format"));
  if (!ending) {
    return Exception(
        400, "InvalidParameterValue", "Format",
        fmt::format("Formats are {}, and {} as it is stored.",
                    image::ListedFormats(&image::PictureFormatRow::content_type), kStoredTileType));
  }
  const Result<MapView> map = FindMap(service, request, *flight_id);
  if (!map) return Exception(map.error());
  const Result<MapSet> set = map->SetNamed(*Parameter(request, "TileMatrixSet"));
  if (!set) return Exception(400, "InvalidParameterValue", "TileMatrixSet", set.error().message);
  const std::string matrix = *Parameter(request, "TileMatrix");
  return WmtsTile{*flight_id,
                  *set,
                  style,
                  std::string(MatrixName(matrix)),
                  *Parameter(request, "TileRow"),
                  *Parameter(request, "TileCol"),
                  *ending};
}

Response KvpTile(Service& service, const Request& request) {
  std::variant<WmtsTile, Response> parsed = ParseKvpTile(service, request);
  if (auto* refused = std::get_if<Response>(&parsed)) return std::move(*refused);
  const WmtsTile& tile = std::get<WmtsTile>(parsed);
  // Where all maps are layers, a set has the zooms of them all, and programs ask each layer for those (QGIS
  // passes the layer's own limits over).
  const bool is_of_any_zoom = *Parameter(request, "Layer") != kLayer;
  return AnswerTileAt(service, request, tile.flight_id, tile.set, tile.style, tile.matrix, tile.row,
                      tile.column + tile.ending, is_of_any_zoom);
}

std::optional<int> PixelIn(std::string_view text, int side_px) {
  const auto pixel = ParseNumber<int>(text);
  return pixel && *pixel >= 0 && *pixel < side_px ? pixel : std::nullopt;
}

// Of the middle of a pixel of a tile.
Result<geo::LatLon> PositionIn(const WmtsTile& tile, int column, int row) {
  if (tile.set.grid) {
    SKYQUILT_TRY_ASSIGN(const TileNumbers numbers, ParseTileNumbers(tile.matrix, tile.column, tile.row));
    return PositionInGrid(*tile.set.grid, numbers.z, numbers.x, numbers.y,
                          {static_cast<double>(column), static_cast<double>(row)});
  }
  SKYQUILT_TRY_ASSIGN(const TilePath path, ParseTilePath(tile.matrix, tile.column, tile.row));
  const geo::Bounds2 bounds = path.tile.BoundsInMerc();
  const double pixel_m = (bounds.max.x() - bounds.min.x()) / tile.set.side_px;
  return geo::LatLonFromMerc(
      {bounds.min.x() + (column + 0.5) * pixel_m, bounds.max.y() - (row + 0.5) * pixel_m});
}

// What lies under a pixel of a tile.
Response KvpInfo(Service& service, const Request& request) {
  std::variant<WmtsTile, Response> parsed = ParseKvpTile(service, request);
  if (auto* refused = std::get_if<Response>(&parsed)) return std::move(*refused);
  const WmtsTile& tile = std::get<WmtsTile>(parsed);
  const std::optional<int> column = PixelIn(Parameter(request, "I").value_or(""), tile.set.side_px);
  const std::optional<int> row = PixelIn(Parameter(request, "J").value_or(""), tile.set.side_px);
  if (!column || !row) {
    return Exception(
        400, "PointIJOutOfRange", column ? "J" : "I",
        fmt::format("I and J are the pixel's column and row, from 0 to {}.", tile.set.side_px - 1));
  }
  const std::string type = Parameter(request, "InfoFormat").value_or("application/json");
  if (!IsInfoFormat(type)) {
    return Exception(400, "InvalidParameterValue", "InfoFormat",
                     "Formats are application/json, application/geo+json, text/plain and text/html.");
  }
  const Result<geo::LatLon> position = PositionIn(tile, *column, *row);
  if (!position) return Exception(400, "TileOutOfRange", "TileRow", position.error().message);
  const Result<MapPoint> point = LookAt(service, tile.flight_id, *position);
  return point ? InfoResponse({*point}, type) : Exception(point.error());
}

Response Kvp(Service& service, const Request& request) {
  const std::string operation = Parameter(request, "Request").value_or("");
  if (AsksForCapabilities(operation)) return AnswerCapabilities(service, request);
  const bool is_info = EqualsIgnoringCase(operation, "GetFeatureInfo");
  if (!is_info && !EqualsIgnoringCase(operation, "GetTile")) {
    return Exception(501, "OperationNotSupported", operation,
                     "Operations are GetCapabilities, GetTile and GetFeatureInfo.");
  }
  const std::string version = Parameter(request, "Version").value_or("1.0.0");
  if (version != "1.0.0") return Exception(400, "InvalidParameterValue", "Version", "The version is 1.0.0.");
  if (!is_info) return KvpTile(service, request);
  // Reads cameras of hundreds of photos.
  if (request.work < Work::kCompute) return DeferTo(Work::kCompute);
  return KvpInfo(service, request);
}

Response RestTile(Service& service, const Request& request) {
  const Result<MapView> map = FindMap(service, request, request.Parameter("flight"));
  if (!map) return Exception(map.error());
  if (request.Parameter("layer") != kLayer)
    return Exception(404, "NotFound", "Layer", "The only layer is \"map\".");
  const Result<MapSet> set = map->SetNamed(request.Parameter("set"));
  if (!set) return Exception(404, "NotFound", "TileMatrixSet", set.error().message);
  return AnswerTileAt(service, request, request.Parameter("flight"), *set, request.Parameter("style"),
                      request.Parameter("matrix"), request.Parameter("row"), request.Parameter("column"),
                      false);
}

}  // namespace

void AddWmtsRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/wmts", On(service, Kvp));
  router.Add(Method::kGet, "/wmts/1.0.0/WMTSCapabilities.xml", On(service, AnswerCapabilities));
  router.Add(Method::kGet, "/wmts/{flight}", On(service, Kvp));
  router.Add(Method::kGet, "/wmts/{flight}/1.0.0/WMTSCapabilities.xml", On(service, AnswerCapabilities));
  router.Add(Method::kGet, "/wmts/{flight}/{layer}/{style}/{set}/{matrix}/{row}/{column}",
             On(service, RestTile));
}

}  // namespace skyquilt::api
