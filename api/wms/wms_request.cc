#include "api/wms/wms_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "api/http/parameters.h"
#include "api/views/feature_info.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

Error BadWms(const char* code, std::string message) {
  return {ErrorCode::kInvalidArgument, std::move(message), code};
}

Result<int> Side(const Request& request, const char* name) {
  const std::optional<double> number = ParseFiniteNumber(Parameter(request, name).value_or(""));
  if (!number || *number != std::floor(*number) || *number < 1 || *number > kMaxWmsSidePx) {
    return BadWms("", fmt::format("{} must be a whole number from 1 to {}.", name, kMaxWmsSidePx));
  }
  return static_cast<int>(*number);
}

Result<std::vector<std::string>> LayersIn(const Request& request, const char* name) {
  const std::string text = Parameter(request, name).value_or("");
  if (text.empty()) return BadWms("LayerNotDefined", fmt::format("{} must name a layer.", name));
  const std::vector<std::string_view> layers = PartsOf(text, ',');
  if (layers.size() > kMaxWmsLayers)
    return BadWms("", fmt::format("{} must name at most {} layers.", name, kMaxWmsLayers));
  return std::vector<std::string>(layers.begin(), layers.end());
}

Result<std::vector<std::string>> StylesIn(const Request& request, std::size_t layers) {
  const std::string text = Parameter(request, "STYLES").value_or("");
  if (text.empty()) return std::vector<std::string>();
  const std::vector<std::string_view> styles = PartsOf(text, ',');
  if (styles.size() > layers)
    return BadWms("StyleNotDefined", "STYLES names more styles than there are layers.");
  return std::vector<std::string>(styles.begin(), styles.end());
}

// All but layers, styles and format.
Result<WmsMap> ParseWindow(const Request& request) {
  WmsMap map;
  const bool is_newer = IsNewerWms(request);
  const std::string crs = Parameter(request, is_newer ? "CRS" : "SRS").value_or("");
  const auto box = FiniteNumbers(Parameter(request, "BBOX").value_or(""), 4);
  if (!box || box->size() != 4) return BadWms("", "BBOX must be four numbers.");
  const double first = (*box)[0], second = (*box)[1], third = (*box)[2], fourth = (*box)[3];
  if (crs == "EPSG:3857" || crs == "EPSG:900913") {
    map = {.west = first, .south = second, .east = third, .north = fourth};
  } else if (crs == "CRS:84" || (crs == "EPSG:4326" && !is_newer)) {
    map = {.west = first, .south = second, .east = third, .north = fourth, .is_geographic = true};
  } else if (crs == "EPSG:4326") {
    map = {.west = second, .south = first, .east = fourth, .north = third, .is_geographic = true};
  } else {
    return BadWms(is_newer ? "InvalidCRS" : "InvalidSRS",
                  "Coordinate systems are EPSG:3857, EPSG:4326 and CRS:84.");
  }
  const double most = map.is_geographic ? 400.0 : 1e8;
  if (!(map.west < map.east) || !(map.south < map.north) || std::abs(map.west) > most ||
      std::abs(map.east) > most || std::abs(map.south) > most || std::abs(map.north) > most) {
    return BadWms("", "BBOX must go from its lower left to its upper right corner, within the world.");
  }
  SKYQUILT_TRY_ASSIGN(const int width, Side(request, "WIDTH"));
  SKYQUILT_TRY_ASSIGN(const int height, Side(request, "HEIGHT"));
  if (width * height > kMaxWmsPixels) return BadWms("", "WIDTH times HEIGHT must not be above 8 million.");
  map.width_px = width;
  map.height_px = height;
  return map;
}

}  // namespace

bool IsNewerWms(const Request& request) {
  // Addresses that people write often name no version; 1.3.0 has no SRS.
  const bool names_srs = Parameter(request, "SRS") && !Parameter(request, "CRS");
  const char* const usual = names_srs ? "1.1.1" : "1.3.0";
  const std::string version =
      Parameter(request, "VERSION").value_or(Parameter(request, "WMTVER").value_or(usual));
  return version >= "1.3";
}

Result<WmsMap> ParseGetMap(const Request& request) {
  SKYQUILT_TRY_ASSIGN(std::vector<std::string> layers, LayersIn(request, "LAYERS"));
  SKYQUILT_TRY_ASSIGN(std::vector<std::string> styles, StylesIn(request, layers.size()));
  SKYQUILT_TRY_ASSIGN(WmsMap map, ParseWindow(request));
  map.layers = std::move(layers);
  map.styles = std::move(styles);
  const std::string format = Parameter(request, "FORMAT").value_or("");
  const auto named = std::find_if(image::kPictureFormats.begin(), image::kPictureFormats.end(),
                                  [&](const auto& row) { return format == row.content_type; });
  if (named != image::kPictureFormats.end()) {
    map.format = named->format;
  } else if (!format.starts_with("image/png")) {  // "image/png; mode=8bit"
    return BadWms("InvalidFormat",
                  "Formats are " + image::ListedFormats(&image::PictureFormatRow::content_type) + ".");
  }
  map.is_transparent = map.format != image::PictureFormat::kJpeg &&
                       EqualsIgnoringCase(Parameter(request, "TRANSPARENT").value_or("FALSE"), "TRUE");
  if (const std::string colour = Parameter(request, "BGCOLOR").value_or(""); !colour.empty()) {
    SKYQUILT_TRY_ASSIGN(map.background, ParseColour(colour, "BGCOLOR"));
  }
  return map;
}

Result<WmsInfo> ParseGetFeatureInfo(const Request& request) {
  WmsInfo info;
  SKYQUILT_TRY_ASSIGN(info.map, ParseWindow(request));
  SKYQUILT_TRY_ASSIGN(info.map.layers, LayersIn(request, "QUERY_LAYERS"));
  const bool is_newer = IsNewerWms(request);
  const auto pixel = [&](const char* name, int side_px) -> Result<int> {
    const std::optional<double> number = ParseFiniteNumber(Parameter(request, name).value_or(""));
    if (!number || *number != std::floor(*number) || *number < 0 || *number >= side_px)
      return BadWms("InvalidPoint",
                    fmt::format("{} must be a whole number from 0 to {}.", name, side_px - 1));
    return static_cast<int>(*number);
  };
  SKYQUILT_TRY_ASSIGN(info.column, pixel(is_newer ? "I" : "X", info.map.width_px));
  SKYQUILT_TRY_ASSIGN(info.row, pixel(is_newer ? "J" : "Y", info.map.height_px));
  info.type = Parameter(request, "INFO_FORMAT").value_or("application/json");
  if (!IsInfoFormat(info.type)) {
    return BadWms("InvalidFormat",
                  "Formats are application/json, application/geo+json, text/plain and text/html.");
  }
  return info;
}

Result<WmsLegend> ParseGetLegendGraphic(const Request& request) {
  WmsLegend legend;
  legend.layer = Parameter(request, "LAYER").value_or(Parameter(request, "LAYERS").value_or(""));
  if (legend.layer.empty()) return BadWms("LayerNotDefined", "LAYER must name a layer.");
  legend.style = Parameter(request, "STYLE").value_or(Parameter(request, "STYLES").value_or(""));
  const std::optional<LegendFormat> format =
      LegendFormatOf(Parameter(request, "FORMAT").value_or("image/png"));
  if (!format) return BadWms("InvalidFormat", "Formats of legends are image/png and image/svg+xml.");
  legend.format = *format;
  return legend;
}

}  // namespace skyquilt::api
