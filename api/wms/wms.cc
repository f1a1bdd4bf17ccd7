// WMS 1.1.1 and 1.3.0 in Web Mercator and geographic coordinates, for ground stations and older GIS programs:
// of one map at /wms/{flight}, with the layer "map", and at /wms of all maps that a request may read, each a
// layer by the flight's id. GetCapabilities, GetMap, GetFeatureInfo. OGC 01-068r3 and 06-042.
#include <fmt/format.h>

#include <string>

#include "api/common/background.h"
#include "api/flights/point.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/indices/index_legend.h"
#include "api/routes.h"
#include "api/tiles/index_values.h"
#include "api/tiles/map_crs.h"
#include "api/tiles/map_window.h"
#include "api/tiles/recode_tile.h"
#include "api/views/feature_info.h"
#include "api/views/listed_maps.h"
#include "api/views/map_view.h"
#include "api/wms/wms_request.h"
#include "core/base/text/xml_text.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_format.h"
#include "core/indices/spectral_index.h"

namespace skyquilt::api {
namespace {

std::string BoxesText(const geo::LatLonBounds& bounds, bool is_newer) {
  const auto& [west, south, east, north] = bounds;
  // Its schema has no longitudes beyond 180 degrees; the boxes by system go on there, as requests do.
  const geo::LatLonBounds stated = bounds.AroundWhereAcross();
  const auto [low, high] = geo::MercFromLatLonBounds(bounds);
  const char* crs = is_newer ? "CRS" : "SRS";
  std::string boxes =
      is_newer ? fmt::format(
                     "<EX_GeographicBoundingBox>"
                     "<westBoundLongitude>{:.9f}</westBoundLongitude>"
                     "<eastBoundLongitude>{:.9f}</eastBoundLongitude>"
                     "<southBoundLatitude>{:.9f}</southBoundLatitude>"
                     "<northBoundLatitude>{:.9f}</northBoundLatitude>"
                     "</EX_GeographicBoundingBox>",
                     stated.west_deg, stated.east_deg, south, north)
               : fmt::format(
                     "<LatLonBoundingBox minx=\"{:.9f}\" miny=\"{:.9f}\" maxx=\"{:.9f}\" maxy=\"{:.9f}\"/>",
                     west, south, east, north);
  boxes += fmt::format(
      "<BoundingBox {}=\"EPSG:3857\" minx=\"{:.4f}\" miny=\"{:.4f}\" maxx=\"{:.4f}\" maxy=\"{:.4f}\"/>", crs,
      low.x(), low.y(), high.x(), high.y());
  // 1.3.0 has latitude first where EPSG says so.
  boxes += fmt::format(
      "<BoundingBox {}=\"EPSG:4326\" minx=\"{:.9f}\" miny=\"{:.9f}\" maxx=\"{:.9f}\" maxy=\"{:.9f}\"/>", crs,
      is_newer ? south : west, is_newer ? west : south, is_newer ? north : east, is_newer ? east : north);
  return boxes;
}

// The map itself, and the indices that its bands are enough for.
std::string StylesText(const ListedMaps& listed, const ListedMap& map) {
  std::string text = "<Style><Name>default</Name><Title>The map</Title></Style>";
  for (const indices::SpectralIndex* index : indices::IndicesOf(map.tiles.bands)) {
    text += fmt::format(
        R"(<Style><Name>{}</Name><Title>{}</Title><LegendURL width="{}" height="{}"><Format>image/png</Format>)"
        R"(<OnlineResource xmlns:xlink="http://www.w3.org/1999/xlink" xlink:type="simple" xlink:href="{}"/>)"
        R"(</LegendURL></Style>)",
        index->name, index->title, kLegendWidthPx, kLegendHeightPx,
        XmlText(listed.Link(LegendPath(map.shown.flight_id, index->name))));
  }
  return text;
}

// What all maps lie within; the world where there is none.
geo::LatLonBounds WholeOf(const ListedMaps& listed) {
  if (listed.maps.empty()) return {-180.0, -85.0, 180.0, 85.0};
  geo::LatLonBounds whole = listed.maps.front().shown.revision.bounds;
  for (const ListedMap& map : listed.maps) whole.Include(map.shown.revision.bounds);
  return whole;
}

// By which WMS 1.1.1 and 1.3.0 describe maps: one, or all in a list.
std::string WmsCapabilities(const ListedMaps& listed, bool is_newer) {
  const std::string href = XmlText(listed.Link("/wms" + listed.path) + (listed.token.empty() ? "?" : "&"));
  const std::string http = fmt::format(
      R"(<DCPType><HTTP><Get>)"
      R"(<OnlineResource xmlns:xlink="http://www.w3.org/1999/xlink" xlink:type="simple" xlink:href="{}"/>)"
      R"(</Get></HTTP></DCPType>)",
      href);
  const std::string root = is_newer
                               ? R"(<WMS_Capabilities version="1.3.0" xmlns="http://www.opengis.net/wms" )"
                                 R"(xmlns:sld="http://www.opengis.net/sld" )"
                                 R"(xmlns:xlink="http://www.w3.org/1999/xlink">)"
                               : R"(<WMT_MS_Capabilities version="1.1.1">)";
  std::string map_formats, info_formats;
  for (const image::PictureFormatRow& row : image::kPictureFormats)
    map_formats += fmt::format("<Format>{}</Format>", row.content_type);
  for (const char* type : kInfoFormats) info_formats += fmt::format("<Format>{}</Format>", type);
  std::string layers;
  for (const ListedMap& map : listed.maps) {
    layers += fmt::format(
        "<Layer queryable=\"1\" opaque=\"0\"><Name>{}</Name><Title>{}</Title>{}{}</Layer>\n", map.layer,
        XmlText(map.shown.name), BoxesText(map.shown.revision.bounds, is_newer), StylesText(listed, map));
  }
  return fmt::format(
      R"({0}
<Service><Name>{1}</Name><Title>{2}</Title>{13}
<OnlineResource xmlns:xlink="http://www.w3.org/1999/xlink" xlink:href="{3}"/>{4}</Service>
<Capability><Request>
<GetCapabilities><Format>{5}</Format>{6}</GetCapabilities>
<GetMap>{16}{6}</GetMap>
<GetFeatureInfo>{14}{6}</GetFeatureInfo>
<{15}><Format>image/png</Format><Format>image/svg+xml</Format>{6}</{15}>
</Request><Exception><Format>{7}</Format></Exception>
<Layer><Title>{2}</Title><{8}>EPSG:3857</{8}><{8}>EPSG:4326</{8}>{9}{10}
{11}</Layer>
</Capability>
{12}
)",
      root, is_newer ? "WMS" : "OGC:WMS", XmlText(listed.title), href,
      is_newer ? fmt::format("<LayerLimit>{0}</LayerLimit><MaxWidth>{1}</MaxWidth><MaxHeight>{1}</MaxHeight>",
                             listed.path.empty() ? kMaxWmsLayers : 1, kMaxWmsSquareSidePx)
               : "",
      is_newer ? "text/xml" : "application/vnd.ogc.wms_xml", http,
      is_newer ? "XML" : "application/vnd.ogc.se_xml", is_newer ? "CRS" : "SRS",
      is_newer ? "<CRS>CRS:84</CRS>" : "", BoxesText(WholeOf(listed), is_newer), layers,
      is_newer ? "</WMS_Capabilities>" : "</WMT_MS_Capabilities>",
      listed.next_cursor ? "<Abstract>" + XmlText(listed.Note()) + "</Abstract>" : "", info_formats,
      is_newer ? "sld:GetLegendGraphic" : "GetLegendGraphic", map_formats);
}

Response WmsException(const Request& request, int status, std::string_view code, std::string_view text) {
  const std::string attribute = code.empty() ? std::string() : fmt::format(" code=\"{}\"", code);
  const char* head =
      IsNewerWms(request) ? "version=\"1.3.0\" xmlns=\"http://www.opengis.net/ogc\"" : "version=\"1.1.1\"";
  Response response = Xml(fmt::format("<ServiceExceptionReport {}><ServiceException{}>{}</ServiceException>"
                                      "</ServiceExceptionReport>\n",
                                      head, attribute, XmlText(text)),
                          IsNewerWms(request) ? "text/xml" : "application/vnd.ogc.se_xml");
  response.status = status;
  return response;
}

Response WmsException(const Request& request, const Error& error) {
  const int status = StatusOf(error.code);
  const std::string_view code = error.code == ErrorCode::kInvalidArgument ? error.detail : std::string_view();
  return WmsException(request, status, code, error.message);
}

MapWindow WindowOfWms(const WmsMap& wanted) {
  const MapCrs crs = wanted.is_geographic ? MapCrs::Crs84() : MapCrs::Mercator();
  geo::Bounds2 box;
  box.min = {wanted.west, wanted.south};
  box.max = {wanted.east, wanted.north};
  return WindowOf(crs, box, wanted.width_px, wanted.height_px, {});
}

// Straight alpha, what is above over what is below.
void LayOver(image::RgbaImage& below, const image::RgbaImage& above) {
  for (std::size_t i = 0; i < below.rgba.size(); i += 4) {
    const int over = above.rgba[i + 3];
    if (over == 0) continue;
    const int under = below.rgba[i + 3] * (255 - over) / 255;
    const int alpha = over + under;
    for (std::size_t c = 0; c < 3; ++c) {
      below.rgba[i + c] = static_cast<std::uint8_t>(
          (above.rgba[i + c] * over + below.rgba[i + c] * under + alpha / 2) / alpha);
    }
    below.rgba[i + 3] = static_cast<std::uint8_t>(alpha);
  }
}

// The flight of a layer, in WMS' words where there is none.
Result<std::string> FlightOfWmsLayer(const Request& request, const std::string& layer) {
  Result<std::string> flight_id = FlightOfLayer(request, layer);
  if (flight_id) return flight_id;
  return Error{ErrorCode::kInvalidArgument, flight_id.error().message, "LayerNotDefined"};
}

// One layer in its style.
Result<image::RgbaImage> DrawLayer(Service& service, const MapView& map, const std::string& style,
                                   const MapWindow& window) {
  const auto refused = [](const Error& error) {
    return Error{error.code, error.message,
                 error.code == ErrorCode::kInvalidArgument ? "StyleNotDefined" : error.detail};
  };
  const Result<std::optional<IndexLook>> look = LookOfStyle(style);
  if (!look) return refused(look.error());
  if (!*look) return RenderWindow(*map.tileset, window);
  const Result<IndexValues> values = ValuesOfWindow(service.bands, *map.tileset, (*look)->expression, window);
  if (!values) return refused(values.error());
  return Coloured(*values, **look);
}

Result<std::string> Draw(Service& service, const Request& request, const WmsMap& wanted) {
  const MapWindow window = WindowOfWms(wanted);
  image::RgbaImage picture;
  for (std::size_t i = 0; i < wanted.layers.size(); ++i) {
    SKYQUILT_TRY_ASSIGN(const std::string flight_id, FlightOfWmsLayer(request, wanted.layers[i]));
    SKYQUILT_TRY_ASSIGN(const MapView map, FindMap(service, request, flight_id));
    const std::string style = i < wanted.styles.size() ? wanted.styles[i] : std::string();
    SKYQUILT_TRY_ASSIGN(image::RgbaImage drawn, DrawLayer(service, map, style, window));
    if (picture.rgba.empty()) {
      picture = std::move(drawn);
    } else {
      LayOver(picture, drawn);
    }
  }
  if (!wanted.is_transparent) LayOn(picture, wanted.background);
  return EncodeTile(std::move(picture), wanted.format);
}

Response GetMap(Service& service, const Request& request) {
  const Result<WmsMap> wanted = ParseGetMap(request);
  if (!wanted) return WmsException(request, wanted.error());
  Result<std::string> drawn = Draw(service, request, *wanted);
  if (!drawn) return WmsException(request, drawn.error());
  return NoCache(Text(200, *std::move(drawn), image::ContentTypeOf(wanted->format)));
}

Response GetFeatureInfo(Service& service, const Request& request) {
  const Result<WmsInfo> wanted = ParseGetFeatureInfo(request);
  if (!wanted) return WmsException(request, wanted.error());
  const MapWindow window = WindowOfWms(wanted->map);
  const geo::LatLon position =
      geo::LatLonFromMerc({window.x_in_merc(wanted->column), window.y_in_merc(wanted->row)});
  std::vector<MapPoint> points;
  for (const std::string& layer : wanted->map.layers) {
    const Result<std::string> flight_id = FlightOfWmsLayer(request, layer);
    if (!flight_id) return WmsException(request, flight_id.error());
    Result<MapPoint> point = LookAt(service, *flight_id, position);
    if (!point) return WmsException(request, point.error());
    // Beside a map there is nothing to tell of it.
    if (point->rgba) points.push_back(*std::move(point));
  }
  return InfoResponse(points, wanted->type);
}

// OGC 05-078r4. The map in its own colours has nothing to explain.
Response GetLegendGraphic(Service& service, const Request& request) {
  const Result<WmsLegend> wanted = ParseGetLegendGraphic(request);
  if (!wanted) return WmsException(request, wanted.error());
  const Result<std::string> flight_id = FlightOfWmsLayer(request, wanted->layer);
  if (!flight_id) return WmsException(request, flight_id.error());
  const Result<MapView> map = FindMap(service, request, *flight_id);
  if (!map) return WmsException(request, map.error());
  const Result<std::optional<IndexLook>> look = LookOfStyle(wanted->style);
  if (!look) return WmsException(request, 400, "StyleNotDefined", look.error().message);
  if (!*look)
    return WmsException(
        request, 400, "StyleNotDefined",
        "The style default has no legend: it is the map in its own colours. STYLE names an index, "
        "such as ndvi.");
  return LegendOf(request, **look, wanted->format);
}

Response DescribeWms(Service& service, const Request& request) {
  const Result<ListedMaps> listed = ListMapsOf(service, request);
  if (!listed) return WmsException(request, listed.error());
  const bool is_newer = IsNewerWms(request);
  return Xml(WmsCapabilities(*listed, is_newer), is_newer ? "text/xml" : "application/vnd.ogc.wms_xml");
}

Response AnswerWms(Service& service, const Request& request) {
  const std::string operation = Parameter(request, "REQUEST").value_or("");
  if (EqualsIgnoringCase(operation, "GetMap") || EqualsIgnoringCase(operation, "map"))
    return GetMap(service, request);
  if (EqualsIgnoringCase(operation, "GetFeatureInfo") || EqualsIgnoringCase(operation, "feature_info"))
    return GetFeatureInfo(service, request);
  if (EqualsIgnoringCase(operation, "GetLegendGraphic")) return GetLegendGraphic(service, request);
  if (AsksForCapabilities(operation)) return DescribeWms(service, request);
  return WmsException(request, 400, "OperationNotSupported",
                      "Operations are GetCapabilities, GetMap, GetFeatureInfo and GetLegendGraphic.");
}

}  // namespace

void AddWmsRoutes(Router& router, Service& service) {
  router.AddCompute(Method::kGet, "/wms", On(service, AnswerWms));
  router.AddCompute(Method::kGet, "/wms/{flight}", On(service, AnswerWms));
}

}  // namespace skyquilt::api
