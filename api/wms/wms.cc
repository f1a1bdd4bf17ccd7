#include "api/wms/wms.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

#include "api/http/problem.h"
#include "api/ogc/map_view.h"
#include "api/tiles/map_window.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

constexpr int kMaxSidePx = 4096;
constexpr int kMaxPixels = 8 << 20;

bool IsNewer(const Request& request) {
  const std::string version =
      Parameter(request, "VERSION").value_or(Parameter(request, "WMTVER").value_or("1.3.0"));
  return version >= "1.3";
}

Response Exception(const Request& request, int status, std::string_view code, std::string_view text) {
  const std::string attribute = code.empty() ? std::string() : fmt::format(" code=\"{}\"", code);
  const char* head =
      IsNewer(request) ? "version=\"1.3.0\" xmlns=\"http://www.opengis.net/ogc\"" : "version=\"1.1.1\"";
  Response response = Xml(fmt::format("<ServiceExceptionReport {}><ServiceException{}>{}</ServiceException>"
                                      "</ServiceExceptionReport>\n",
                                      head, attribute, XmlText(text)),
                          IsNewer(request) ? "text/xml" : "application/vnd.ogc.se_xml");
  response.status = status;
  return response;
}

std::optional<double> Number(std::string_view text) {
  double number = 0.0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || parsed.ec != std::errc() || parsed.ptr != text.data() + text.size())
    return std::nullopt;
  if (!std::isfinite(number)) return std::nullopt;
  return number;
}

std::optional<std::array<double, 4>> FourNumbers(std::string_view text) {
  std::array<double, 4> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t comma = text.find(',');
    if ((comma == std::string_view::npos) != (i == 3)) return std::nullopt;
    const std::optional<double> number = Number(text.substr(0, comma));
    if (!number) return std::nullopt;
    numbers[i] = *number;
    text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
  }
  return numbers;
}

Error Bad(const char* code, std::string message) {
  return {ErrorCode::kInvalidArgument, std::move(message), code};
}

Result<int> Side(const Request& request, const char* name) {
  const std::optional<double> number = Number(Parameter(request, name).value_or(""));
  if (!number || *number != std::floor(*number) || *number < 1 || *number > kMaxSidePx) {
    return Bad("", fmt::format("{} must be a whole number from 1 to {}.", name, kMaxSidePx));
  }
  return static_cast<int>(*number);
}

std::string Capabilities(const MapView& map, bool is_newer) {
  const auto& [west, south, east, north] = map.revision().bounds;
  const auto [low, high] = geo::MercFromLatLonBounds(map.revision().bounds);
  const std::string href = XmlText(map.Link("/wms/" + map.id) + (map.token.empty() ? "?" : "&"));
  const std::string http = fmt::format(
      R"(<DCPType><HTTP><Get>)"
      R"(<OnlineResource xmlns:xlink="http://www.w3.org/1999/xlink" xlink:type="simple" xlink:href="{}"/>)"
      R"(</Get></HTTP></DCPType>)",
      href);
  const char* crs = is_newer ? "CRS" : "SRS";
  std::string boxes =
      is_newer ? fmt::format(
                     "<EX_GeographicBoundingBox>"
                     "<westBoundLongitude>{:.9f}</westBoundLongitude>"
                     "<eastBoundLongitude>{:.9f}</eastBoundLongitude>"
                     "<southBoundLatitude>{:.9f}</southBoundLatitude>"
                     "<northBoundLatitude>{:.9f}</northBoundLatitude>"
                     "</EX_GeographicBoundingBox>",
                     west, east, south, north)
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
  const std::string root = is_newer
                               ? R"(<WMS_Capabilities version="1.3.0" xmlns="http://www.opengis.net/wms" )"
                                 R"(xmlns:xlink="http://www.w3.org/1999/xlink">)"
                               : R"(<WMT_MS_Capabilities version="1.1.1">)";
  return fmt::format(
      R"({0}
<Service><Name>{1}</Name><Title>{2}</Title>
<OnlineResource xmlns:xlink="http://www.w3.org/1999/xlink" xlink:href="{3}"/>{4}</Service>
<Capability><Request>
<GetCapabilities><Format>{5}</Format>{6}</GetCapabilities>
<GetMap><Format>image/png</Format><Format>image/jpeg</Format><Format>image/webp</Format>{6}</GetMap>
</Request><Exception><Format>{7}</Format></Exception>
<Layer><Title>{2}</Title><{8}>EPSG:3857</{8}><{8}>EPSG:4326</{8}>{9}{10}
<Layer queryable="0" opaque="0"><Name>map</Name><Title>{2}</Title>{10}</Layer></Layer>
</Capability>
{11}
)",
      root, is_newer ? "WMS" : "OGC:WMS", XmlText(map.name), href,
      is_newer ? fmt::format("<MaxWidth>{0}</MaxWidth><MaxHeight>{0}</MaxHeight>", kMaxSidePx) : "",
      is_newer ? "text/xml" : "application/vnd.ogc.wms_xml", http,
      is_newer ? "XML" : "application/vnd.ogc.se_xml", crs, is_newer ? "<CRS>CRS:84</CRS>" : "", boxes,
      is_newer ? "</WMS_Capabilities>" : "</WMT_MS_Capabilities>");
}

Result<std::string> Draw(const MapView& map, const WmsMap& wanted) {
  const double width = (wanted.east - wanted.west) / wanted.width_px;
  const double height = (wanted.north - wanted.south) / wanted.height_px;
  MapWindow window;
  window.width_px = wanted.width_px;
  window.height_px = wanted.height_px;
  if (wanted.is_geographic) {
    const auto merc = [](double lat_deg, double lon_deg) {
      return geo::MercFromLatLon({.lat_deg = lat_deg, .lon_deg = lon_deg});
    };
    const double lat_deg = std::min(std::abs((wanted.south + wanted.north) / 2), 85.0);
    window.pixel_m = std::min(merc(0.0, width).x(), merc(lat_deg + height, 0.0).y() - merc(lat_deg, 0.0).y());
    window.x_in_merc = [=](int column) { return merc(0.0, wanted.west + (column + 0.5) * width).x(); };
    window.y_in_merc = [=](int row) {
      return merc(std::clamp(wanted.north - (row + 0.5) * height, -89.9, 89.9), 0.0).y();
    };
  } else {
    window.pixel_m = std::min(width, height);
    window.x_in_merc = [=](int column) { return wanted.west + (column + 0.5) * width; };
    window.y_in_merc = [=](int row) { return wanted.north - (row + 0.5) * height; };
  }
  SKYQUILT_TRY_ASSIGN(image::RgbaImage pixels, RenderWindow(*map.tileset, window));
  if (!wanted.is_transparent) {
    for (std::size_t i = 0; i < pixels.rgba.size(); i += 4) {
      const int alpha = pixels.rgba[i + 3];
      for (std::size_t c = 0; c < 3; ++c) {
        pixels.rgba[i + c] =
            static_cast<std::uint8_t>((pixels.rgba[i + c] * alpha + 255 * (255 - alpha) + 127) / 255);
      }
      pixels.rgba[i + 3] = 255;
    }
  }
  return EncodeTile(std::move(pixels), wanted.format);
}

Response GetMap(Service& service, const Request& request) {
  const Result<WmsMap> wanted = ParseGetMap(request);
  if (!wanted) return Exception(request, 400, wanted.error().detail, wanted.error().message);
  const Result<MapView> map = FindMap(service, request, request.Parameter("flight"));
  if (!map) return Exception(request, StatusOf(map.error().code), "", map.error().message);
  Result<std::string> drawn = Draw(*map, *wanted);
  if (!drawn) return Exception(request, StatusOf(drawn.error().code), "", drawn.error().message);
  Response response;
  response.headers.Add("Content-Type", image::ContentTypeOf(wanted->format));
  response.headers.Add("Cache-Control", "no-cache");
  response.body = *std::move(drawn);
  return response;
}

Response DescribeWms(Service& service, const Request& request) {
  const Result<MapView> map = FindMap(service, request, request.Parameter("flight"));
  if (!map) return Exception(request, StatusOf(map.error().code), "", map.error().message);
  const bool is_newer = IsNewer(request);
  return Xml(Capabilities(*map, is_newer), is_newer ? "text/xml" : "application/vnd.ogc.wms_xml");
}

Response Answer(Service& service, const Request& request) {
  const std::string operation = Parameter(request, "REQUEST").value_or("");
  if (EqualsIgnoringCase(operation, "GetMap") || EqualsIgnoringCase(operation, "map"))
    return GetMap(service, request);
  if (AsksForCapabilities(operation)) return DescribeWms(service, request);
  return Exception(request, 400, "OperationNotSupported", "Operations are GetCapabilities and GetMap.");
}

}  // namespace

Result<WmsMap> ParseGetMap(const Request& request) {
  WmsMap map;
  const bool is_newer = IsNewer(request);
  if (Parameter(request, "LAYERS").value_or("") != "map")
    return Bad("LayerNotDefined", "The only layer is \"map\".");
  const std::string style = Parameter(request, "STYLES").value_or("");
  if (!style.empty() && style != "default") return Bad("StyleNotDefined", "The only style is the default.");
  const std::string crs = Parameter(request, is_newer ? "CRS" : "SRS").value_or("");
  const auto box = FourNumbers(Parameter(request, "BBOX").value_or(""));
  if (!box) return Bad("", "BBOX must be four numbers.");
  const auto& [first, second, third, fourth] = *box;
  if (crs == "EPSG:3857" || crs == "EPSG:900913") {
    map = {.west = first, .south = second, .east = third, .north = fourth};
  } else if (crs == "CRS:84" || (crs == "EPSG:4326" && !is_newer)) {
    map = {.west = first, .south = second, .east = third, .north = fourth, .is_geographic = true};
  } else if (crs == "EPSG:4326") {
    map = {.west = second, .south = first, .east = fourth, .north = third, .is_geographic = true};
  } else {
    return Bad(is_newer ? "InvalidCRS" : "InvalidSRS",
               "Coordinate systems are EPSG:3857, EPSG:4326 and CRS:84.");
  }
  const double most = map.is_geographic ? 400.0 : 1e8;
  if (!(map.west < map.east) || !(map.south < map.north) || std::abs(map.west) > most ||
      std::abs(map.east) > most || std::abs(map.south) > most || std::abs(map.north) > most) {
    return Bad("", "BBOX must go from its lower left to its upper right corner, within the world.");
  }
  SKYQUILT_TRY_ASSIGN(const int width, Side(request, "WIDTH"));
  SKYQUILT_TRY_ASSIGN(const int height, Side(request, "HEIGHT"));
  if (width * height > kMaxPixels) return Bad("", "WIDTH times HEIGHT must not be above 8 million.");
  map.width_px = width;
  map.height_px = height;
  const std::string format = Parameter(request, "FORMAT").value_or("");
  if (format == "image/jpeg") {
    map.format = image::PictureFormat::kJpeg;
  } else if (format == "image/webp") {
    map.format = image::PictureFormat::kWebp;
  } else if (!format.starts_with("image/png")) {
    return Bad("InvalidFormat", "Formats are image/png, image/jpeg and image/webp.");
  }
  map.is_transparent = EqualsIgnoringCase(Parameter(request, "TRANSPARENT").value_or("FALSE"), "TRUE");
  return map;
}

void AddWmsRoutes(Router& router, Service& service) {
  router.AddCompute(Method::kGet, "/wms/{flight}", [&](const Request& r) { return Answer(service, r); });
}

}  // namespace skyquilt::api
