#include "api/wmts/wmts.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "api/http/problem.h"
#include "api/ogc/map_view.h"
#include "api/tiles/cut_tile.h"
#include "api/tiles/tile_path.h"
#include "api/tiles/tiles.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

constexpr const char* kLayer = "map";

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

std::string Operation(const char* name, const MapView& map, const std::string& rest) {
  const std::string separator = map.token.empty() ? "?" : "&";
  const auto get = [](const std::string& href, const char* encoding) {
    return fmt::format(
        R"(<ows:Get xlink:href="{}"><ows:Constraint name="GetEncoding">)"
        R"(<ows:AllowedValues><ows:Value>{}</ows:Value></ows:AllowedValues></ows:Constraint></ows:Get>)",
        XmlText(href), encoding);
  };
  return fmt::format(
      "    <ows:Operation name=\"{}\"><ows:DCP><ows:HTTP>{}{}</ows:HTTP></ows:DCP></ows:Operation>\n", name,
      get(map.Link("/wmts/" + map.id) + separator, "KVP"), get(rest, "RESTful"));
}

struct TileType {
  const char* type;
  const char* extension;
};
// Programs take the first. That is what is stored, where all tiles are of one format; maps of JPEG have PNG
// at their fringe, and a JPEG there would be black where nothing was seen: of them PNG comes first.
std::vector<TileType> TypesOf(const MapView& map) {
  std::vector<TileType> types = {{"image/png", "png"}, {"image/jpeg", "jpg"}, {"image/webp", "webp"}};
  const auto& metadata = map.tileset->reader->metadata();
  const auto format = metadata.find("format");
  if (format != metadata.end() && format->second == "webp")
    std::rotate(types.begin(), types.end() - 1, types.end());
  return types;
}

std::string Layer(const MapView& map) {
  const auto& [west, south, east, north] = map.revision().bounds;
  std::string text = fmt::format(
      R"(    <Layer>
      <ows:Title>{0}</ows:Title>
      <ows:WGS84BoundingBox>
        <ows:LowerCorner>{1:.9f} {2:.9f}</ows:LowerCorner><ows:UpperCorner>{3:.9f} {4:.9f}</ows:UpperCorner>
      </ows:WGS84BoundingBox>
      <ows:Identifier>{5}</ows:Identifier>
      <Style isDefault="true"><ows:Identifier>default</ows:Identifier></Style>
)",
      XmlText(map.name), west, south, east, north, kLayer);
  const std::vector<TileType> types = TypesOf(map);
  for (const TileType& type : types) text += fmt::format("      <Format>{}</Format>\n", type.type);
  for (const int side_px : map.tile_sizes_px()) {
    text += fmt::format("      <TileMatrixSetLink><TileMatrixSet>{}</TileMatrixSet><TileMatrixSetLimits>\n",
                        MatrixSetName(side_px));
    for (const TileMatrix& matrix : MatricesOf(map, side_px)) {
      text += fmt::format(
          "        <TileMatrixLimits><TileMatrix>{}</TileMatrix>"
          "<MinTileRow>{}</MinTileRow><MaxTileRow>{}</MaxTileRow>"
          "<MinTileCol>{}</MinTileCol><MaxTileCol>{}</MaxTileCol></TileMatrixLimits>\n",
          matrix.zoom, matrix.min_row, matrix.max_row, matrix.min_column, matrix.max_column);
    }
    text += "      </TileMatrixSetLimits></TileMatrixSetLink>\n";
  }
  for (const auto& [type, extension] : types) {
    const std::string path =
        fmt::format("/wmts/{}/{}/{{Style}}/{{TileMatrixSet}}/{{TileMatrix}}/{{TileRow}}/{{TileCol}}.{}",
                    map.id, kLayer, extension);
    text += fmt::format("      <ResourceURL format=\"{}\" resourceType=\"tile\" template=\"{}\"/>\n", type,
                        XmlText(map.Link(path)));
  }
  return text + "    </Layer>\n";
}

std::string MatrixSet(const MapView& map, int side_px) {
  std::string text = fmt::format(
      R"(    <TileMatrixSet>
      <ows:Identifier>{}</ows:Identifier>
      <ows:SupportedCRS>urn:ogc:def:crs:EPSG::3857</ows:SupportedCRS>
)",
      MatrixSetName(side_px));
  if (side_px == kUsualTilePx) {
    text += "      <WellKnownScaleSet>urn:ogc:def:wkss:OGC:1.0:GoogleMapsCompatible</WellKnownScaleSet>\n";
  }
  for (const TileMatrix& matrix : MatricesOf(map, side_px)) {
    text += fmt::format(
        "      <TileMatrix><ows:Identifier>{0}</ows:Identifier><ScaleDenominator>{1:.12f}</ScaleDenominator>"
        "<TopLeftCorner>-{2:.9f} "
        "{2:.9f}</TopLeftCorner><TileWidth>{3}</TileWidth><TileHeight>{3}</TileHeight>"
        "<MatrixWidth>{4}</MatrixWidth><MatrixHeight>{4}</MatrixHeight></TileMatrix>\n",
        matrix.zoom, matrix.scale_denominator, geo::kMercHalfWidthM, side_px,
        std::uint64_t{1} << matrix.zoom);
  }
  return text + "    </TileMatrixSet>\n";
}

std::string Capabilities(const MapView& map) {
  const std::string rest = "/wmts/" + map.id + "/1.0.0/WMTSCapabilities.xml";
  const std::string tile =
      fmt::format("/wmts/{}/{}/default/{}/", map.id, kLayer, MatrixSetName(map.tile_sizes_px().front()));
  std::string sets;
  for (const int side_px : map.tile_sizes_px()) sets += MatrixSet(map, side_px);
  return fmt::format(
             R"(<Capabilities version="1.0.0" xmlns="http://www.opengis.net/wmts/1.0"
  xmlns:ows="http://www.opengis.net/ows/1.1" xmlns:xlink="http://www.w3.org/1999/xlink"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="http://www.opengis.net/wmts/1.0
  http://schemas.opengis.net/wmts/1.0/wmtsGetCapabilities_response.xsd">
  <ows:ServiceIdentification>
    <ows:Title>{}</ows:Title>
    <ows:ServiceType>OGC WMTS</ows:ServiceType>
    <ows:ServiceTypeVersion>1.0.0</ows:ServiceTypeVersion>
  </ows:ServiceIdentification>
  <ows:ServiceProvider>
    <ows:ProviderName>Skyquilt</ows:ProviderName><ows:ServiceContact/>
  </ows:ServiceProvider>
  <ows:OperationsMetadata>
)",
             XmlText(map.name)) +
         Operation("GetCapabilities", map, map.Link(rest)) + Operation("GetTile", map, map.Link(tile)) +
         "  </ows:OperationsMetadata>\n  <Contents>\n" + Layer(map) + sets + "  </Contents>\n" +
         fmt::format("  <ServiceMetadataURL xlink:href=\"{}\"/>\n</Capabilities>\n", XmlText(map.Link(rest)));
}

Response AnswerCapabilities(Service& service, const Request& request) {
  const Result<MapView> map = FindMap(service, request, request.Parameter("flight"));
  return map ? Xml(Capabilities(*map)) : Exception(map.error());
}

std::optional<std::string> ExtensionOfType(std::string_view type) {
  if (type == "image/png") return "png";
  if (type == "image/jpeg") return "jpg";
  if (type == "image/webp") return "webp";
  return std::nullopt;
}

Response AnswerTileAt(Service& service, const Request& request, int side_px, std::string_view matrix,
                      std::string_view row, std::string_view column_and_extension) {
  // Column and row stand the other way round in our own addresses.
  const std::size_t dot = column_and_extension.find('.');
  std::string y(row);
  if (dot != std::string_view::npos) y += column_and_extension.substr(dot);
  const Result<TilePath> path = ParseTilePath(matrix, column_and_extension.substr(0, dot), y);
  if (!path) return Exception(400, "TileOutOfRange", "TileRow", path.error().message);
  TileRequest wanted;
  wanted.flight_id = request.Parameter("flight");
  wanted.tile = path->tile;
  wanted.format = path->format;
  wanted.side_px = side_px;
  Result<Response> answer = AnswerTile(service, request, wanted);
  if (!answer) return Exception(answer.error());
  return TileResponse(std::move(answer), request);
}

// "1" and "EPSG:3857:1" alike: some clients put the set before the matrix.
std::string_view MatrixName(std::string_view text) { return text.substr(text.rfind(':') + 1); }

Response KvpTile(Service& service, const Request& request) {
  const std::string& id = request.Parameter("flight");
  for (const char* name : {"Layer", "Format", "TileMatrixSet", "TileMatrix", "TileRow", "TileCol"}) {
    if (!Parameter(request, name))
      return Exception(400, "MissingParameterValue", name, "This parameter is missing.");
  }
  if (*Parameter(request, "Layer") != kLayer) {
    return Exception(400, "InvalidParameterValue", "Layer", "The only layer is \"map\".");
  }
  const std::string style = Parameter(request, "Style").value_or("default");
  if (!style.empty() && style != "default") {
    return Exception(400, "InvalidParameterValue", "Style", "The only style is \"default\".");
  }
  const std::optional<std::string> extension = ExtensionOfType(*Parameter(request, "Format"));
  if (!extension) {
    return Exception(400, "InvalidParameterValue", "Format",
                     "Formats are image/png, image/jpeg and image/webp.");
  }
  const Result<MapView> map = FindMap(service, request, id);
  if (!map) return Exception(map.error());
  const Result<int> side_px = map->SizeOfSet(*Parameter(request, "TileMatrixSet"));
  if (!side_px) return Exception(400, "InvalidParameterValue", "TileMatrixSet", side_px.error().message);
  const std::string matrix = *Parameter(request, "TileMatrix");
  return AnswerTileAt(service, request, *side_px, MatrixName(matrix), *Parameter(request, "TileRow"),
                      *Parameter(request, "TileCol") + "." + *extension);
}

Response Kvp(Service& service, const Request& request) {
  const std::string operation = Parameter(request, "Request").value_or("");
  if (AsksForCapabilities(operation)) return AnswerCapabilities(service, request);
  if (!EqualsIgnoringCase(operation, "GetTile")) {
    return Exception(501, "OperationNotSupported", operation, "Operations are GetCapabilities and GetTile.");
  }
  const std::string version = Parameter(request, "Version").value_or("1.0.0");
  if (version != "1.0.0") return Exception(400, "InvalidParameterValue", "Version", "The version is 1.0.0.");
  return KvpTile(service, request);
}

Response RestTile(Service& service, const Request& request) {
  const Result<MapView> map = FindMap(service, request, request.Parameter("flight"));
  if (!map) return Exception(map.error());
  if (request.Parameter("layer") != kLayer)
    return Exception(404, "NotFound", "Layer", "The only layer is \"map\".");
  if (request.Parameter("style") != "default")
    return Exception(404, "NotFound", "Style", "The only style is \"default\".");
  const Result<int> side_px = map->SizeOfSet(request.Parameter("set"));
  if (!side_px) return Exception(404, "NotFound", "TileMatrixSet", side_px.error().message);
  return AnswerTileAt(service, request, *side_px, request.Parameter("matrix"), request.Parameter("row"),
                      request.Parameter("column"));
}

}  // namespace

void AddWmtsRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/wmts/{flight}", [&](const Request& r) { return Kvp(service, r); });
  router.Add(Method::kGet, "/wmts/{flight}/1.0.0/WMTSCapabilities.xml",
             [&](const Request& r) { return AnswerCapabilities(service, r); });
  router.Add(Method::kGet, "/wmts/{flight}/{layer}/{style}/{set}/{matrix}/{row}/{column}",
             [&](const Request& r) { return RestTile(service, r); });
}

}  // namespace skyquilt::api
