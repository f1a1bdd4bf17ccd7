#include "storage/exports/custom/export_request.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/check.h"
#include "core/base/text/json_io.h"
#include "core/base/text/plain_text.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/crs/reference_system.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/indices/spectral_index.h"
#include "storage/exports/custom/target_crs.h"
#include "storage/exports/warped/warp_tiles.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {
namespace {

using Json = nlohmann::json;

struct FormatWords {
  ExportFormat format;
  const char* name;
  const char* ending;
  const char* content_type;
};
constexpr std::array<FormatWords, 5> kFormats = {{
    {ExportFormat::kGeotiff, "geotiff", "tif", "image/tiff; application=geotiff; profile=cloud-optimized"},
    {ExportFormat::kPmtiles, "pmtiles", "pmtiles", "application/vnd.pmtiles"},
    {ExportFormat::kMbtiles, "mbtiles", "mbtiles", "application/vnd.sqlite3"},
    {ExportFormat::kKmz, "kmz", "kmz", "application/vnd.google-earth.kmz"},
    {ExportFormat::kReport, "report", "pdf", "application/pdf"},
}};

constexpr double kCoarsestM = 100'000.0;
// So much finer than the map is a rounded figure of the map's own.
constexpr double kFinerTolerance = 0.95;

const FormatWords& WordsOf(ExportFormat format) {
  return *std::find_if(kFormats.begin(), kFormats.end(),
                       [&](const auto& one) { return one.format == format; });
}

constexpr const char* kFormatNames = "\"geotiff\", \"pmtiles\", \"mbtiles\", \"kmz\" or \"report\".";

Error Refused(flight::Remark why) { return flight::Because(ErrorCode::kUnprocessable, std::move(why)); }

Result<void> TakeField(const std::string& field, const Json& value, ExportRequest& request,
                       bool& has_format) {
  if (field == "format") {
    const auto format = value.is_string() ? ExportFormatOfName(value.get<std::string>()) : std::nullopt;
    if (!format) return Refused(fmt::format("The field \"format\" must be {}", kFormatNames));
    request.format = *format;
    has_format = true;
    return {};
  }
  if (value.is_null()) return {};
  if (field == "crs") {
    if (!value.is_string())
      return Refused("The field \"crs\" must be \"utm\" or a code such as \"EPSG:2056\".");
    request.crs = value.get<std::string>();
    SKYQUILT_TRY(EpsgOf(request.crs, {}));
    return {};
  }
  if (field == "boundary") {
    SKYQUILT_TRY_ASSIGN(request.boundary, ParseBoundary(JsonText(value)));
    return {};
  }
  if (field == "resolution_m") {
    const double metres = value.is_number() ? value.get<double>() : 0.0;
    if (!(metres > 0.0 && metres <= kCoarsestM))
      return Refused(
          "The field \"resolution_m\" must be the size of a pixel on the ground in metres, above 0.");
    request.resolution_m = metres;
    return {};
  }
  if (field == "index") {
    if (!value.is_string() || indices::FindIndex(value.get<std::string>()) == nullptr)
      return Refused(
          "The field \"index\" must be the name of an index, such as \"ndvi\"; any other is an \"expression\".");
    request.index = value.get<std::string>();
    return {};
  }
  if (field == "name") {
    constexpr std::size_t kMaxNameBytes = 400;  // as that of a flight
    if (!value.is_string() || value.get<std::string>().size() > kMaxNameBytes)
      return Refused("The field \"name\" must be what the report calls the map.");
    request.name = value.get<std::string>();
    return {};
  }
  if (field == "expression") {
    if (!value.is_string())
      return Refused("The field \"expression\" must be a formula such as \"(nir-red)/(nir+red)\".");
    request.expression = value.get<std::string>();
    const auto parsed = indices::BandExpression::Parse(request.expression);
    if (!parsed) return Refused(parsed.error().message);
    return {};
  }
  return Refused(fmt::format("The field \"{}\" is not known.", field.substr(0, 40)));
}

Result<void> CheckResolution(double metres, const MapFacts& map) {
  if (metres < map.FinestPixelM() * kFinerTolerance)
    return Refused(
        {flight::RemarkCode::kExportFinerThanMap, {{"finest_m", map.FinestPixelM()}, {"asked_m", metres}}});
  const double height_m = geo::DegToRad(map.bounds.north_deg - map.bounds.south_deg) * geo::kWgs84SemiMajorM;
  const double width_m = geo::DegToRad(map.bounds.east_deg - map.bounds.west_deg) * geo::kWgs84SemiMajorM *
                         std::cos(geo::DegToRad(map.bounds.Middle().lat_deg));
  if (metres > std::max(height_m, width_m))
    return Refused({flight::RemarkCode::kExportBeyondMap, {{"asked_m", metres}}});
  return {};
}

}  // namespace

const char* NameOf(ExportFormat format) { return WordsOf(format).name; }
const char* EndingOf(ExportFormat format) { return WordsOf(format).ending; }
const char* ContentTypeOf(ExportFormat format) { return WordsOf(format).content_type; }

std::optional<ExportFormat> ExportFormatOfName(std::string_view name) {
  for (const FormatWords& one : kFormats) {
    if (name == one.name) return one.format;
  }
  return std::nullopt;
}

std::optional<ExportFormat> ExportFormatOfFile(std::string_view file_name) {
  std::string ending = LowerCase(file_name.substr(file_name.rfind('.') + 1));
  if (ending == "tiff") ending = "tif";
  for (const FormatWords& one : kFormats) {
    if (ending == one.ending && one.format != ExportFormat::kReport) return one.format;
  }
  return std::nullopt;
}

Result<ExportRequest> ParseExportRequest(std::string_view json) {
  const Json parsed = ParseJson(json);
  if (!parsed.is_object())
    return Error{ErrorCode::kInvalidArgument,
                 "Send the wish as a JSON object such as {\"format\":\"geotiff\"}.", ""};
  ExportRequest request;
  bool has_format = false;
  for (const auto& [field, value] : parsed.items())
    SKYQUILT_TRY(TakeField(field, value, request, has_format));
  if (!has_format) return Refused(fmt::format("Say the format: \"format\" is {}", kFormatNames));
  if (request.format == ExportFormat::kReport) {
    if (!request.crs.empty() || request.boundary || request.resolution_m || request.IsOfValues())
      return Refused(
          "A report is of the whole map; leave out \"crs\", \"boundary\", \"resolution_m\", \"index\" and "
          "\"expression\".");
    return request;
  }
  if (!request.name.empty()) return Refused("Only a report has a \"name\".");
  if (!request.crs.empty() && request.format != ExportFormat::kGeotiff)
    return Refused(fmt::format("{} is always in Web Mercator; leave out \"crs\", or take a GeoTIFF.",
                               NameOf(request.format)));
  if (request.IsOfValues() && request.format != ExportFormat::kGeotiff)
    return Refused(
        "The values of an index are a GeoTIFF; leave out \"index\" and \"expression\", or take \"geotiff\".");
  if (!request.index.empty() && !request.expression.empty())
    return Refused("Send \"index\" or \"expression\", not both.");
  return request;
}

std::string IndexNameOf(const ExportRequest& request) {
  const indices::SpectralIndex* const known = indices::FindIndex(request.index);
  return known != nullptr ? std::string(known->title) : request.expression;
}

indices::BandExpression ExpressionOf(const ExportRequest& request) {
  const indices::SpectralIndex* const known = indices::FindIndex(request.index);
  Result<indices::BandExpression> parsed = indices::BandExpression::Parse(
      known != nullptr ? known->expression : std::string_view(request.expression));
  SKYQUILT_CHECK(parsed.ok(), "what was parsed before is parsed again");
  return *std::move(parsed);
}

bool IsAsStored(const ExportRequest& request) {
  return (request.crs.empty() || request.crs.ends_with(":3857")) && !request.resolution_m;
}

namespace {

// What stands for the code in "EPSG:32633", and in the same as a URN, with a version before it or without
// (OGC 07-092r1); "32633+5773" of a system that also counts heights.
std::string_view WrittenCode(std::string_view crs) {
  constexpr std::string_view kUrn = "urn:ogc:def:crs:EPSG:";
  if (crs.starts_with(kUrn)) {
    crs.remove_prefix(kUrn.size());
    const std::size_t version_end = crs.find(':');
    return version_end == std::string_view::npos ? std::string_view() : crs.substr(version_end + 1);
  }
  const bool is_code = crs.starts_with("EPSG:") || crs.starts_with("epsg:");
  return is_code ? crs.substr(5) : std::string_view();
}

std::optional<int> CodeOf(std::string_view digits) {
  constexpr std::size_t kMaxDigits = 6;
  if (digits.size() > kMaxDigits) return std::nullopt;
  const std::optional<int> code = ParseNumber<int>(digits);
  return code && *code >= 1 ? code : std::nullopt;
}

}  // namespace

Result<int> EpsgOf(const std::string& crs, const geo::LatLon& middle) {
  if (crs.empty()) return 3857;
  if (crs == "utm" || crs == "UTM") {
    Result<int> zone = UtmEpsg(middle);
    if (!zone) return Refused(flight::RemarkCode::kExportBeyondUtm);
    return zone;
  }
  const std::string_view written = WrittenCode(crs);
  const std::size_t plus = written.find('+');
  const std::optional<int> code = CodeOf(written.substr(0, plus));
  if (!code) return Refused("The coordinate system must be \"utm\" or a code such as \"EPSG:2056\".");
  if (plus != std::string_view::npos)
    return Refused({flight::RemarkCode::kExportSystemCompound, {{"epsg", *code}}});
  return *code;
}

std::optional<flight::Remark> RemarkOnCrs(const std::string& crs, const geo::LatLon& middle) {
  const Result<int> epsg = EpsgOf(crs, middle);
  if (!epsg) return std::nullopt;
  const auto system = geo::ReferenceSystem::Parse("EPSG:" + std::to_string(*epsg));
  if (!system) return std::nullopt;
  const std::optional<double> error_m =
      system->InexactShiftM({middle.lat_deg, std::remainder(middle.lon_deg, 360.0)});
  if (!error_m) return std::nullopt;
  return flight::Remark(flight::RemarkCode::kExportSystemInexact, {{"epsg", *epsg}, {"error_m", *error_m}});
}

double MapFacts::PixelM(int zoom) const {
  return geo::PixelSizeInMercM(zoom, tile_size_px) * geo::GroundMetresPerMercMetre(bounds.Middle().lat_deg);
}

Result<MapFacts> FactsOfTileset(const TilesetFacts& metadata) {
  MapFacts facts;
  facts.min_zoom = TilesetNumber(metadata, "minzoom", -1);
  facts.max_zoom = TilesetNumber(metadata, "maxzoom", -1);
  facts.tile_size_px = TilesetNumber(metadata, "tile_size", 256);
  facts.bounds = TilesetBounds(metadata).value_or(geo::LatLonBounds()).OnEarth();
  const geo::LatLonBounds& box = facts.bounds;
  const bool is_sound =
      facts.min_zoom >= 0 && facts.max_zoom >= facts.min_zoom && facts.max_zoom <= geo::kMaxZoom &&
      facts.tile_size_px >= 64 && facts.tile_size_px <= 4096 && box.west_deg < box.east_deg &&
      box.south_deg < box.north_deg && std::abs(box.south_deg) <= 90.0 && std::abs(box.north_deg) <= 90.0;
  if (!is_sound)
    return Error{ErrorCode::kCorrupt,
                 "The tileset does not say what it covers (bounds, minzoom, maxzoom). Make the map again.",
                 ""};
  return facts;
}

Result<void> CheckExport(const ExportRequest& request, const MapFacts& map) {
  const bool needs_place = !request.crs.empty() || request.boundary || request.resolution_m;
  if (needs_place && !map.is_placed) return Refused(flight::RemarkCode::kExportWithoutPlace);
  if (!request.crs.empty()) {
    SKYQUILT_TRY_ASSIGN(const int epsg, EpsgOf(request.crs, map.bounds.Middle()));
    SKYQUILT_TRY(FindTargetCrs(epsg, map.bounds.Middle()));
  }
  if (request.boundary) {
    const geo::LatLonBounds common = Common(map.bounds, request.boundary->Bounds());
    if (common.west_deg >= common.east_deg || common.south_deg >= common.north_deg)
      return Refused({flight::RemarkCode::kExportOutsideMap,
                      {{"south_deg", map.bounds.south_deg},
                       {"west_deg", map.bounds.west_deg},
                       {"north_deg", map.bounds.north_deg},
                       {"east_deg", map.bounds.east_deg}}});
  }
  if (request.resolution_m) SKYQUILT_TRY(CheckResolution(*request.resolution_m, map));
  return {};
}

int ZoomOfExport(const ExportRequest& request, const MapFacts& map) {
  int zoom = map.max_zoom;
  constexpr double kRounding = 1.001;
  while (request.resolution_m && zoom > map.min_zoom &&
         map.PixelM(zoom - 1) <= *request.resolution_m * kRounding)
    --zoom;
  return zoom;
}

geo::LatLonBounds Common(const geo::LatLonBounds& a, const geo::LatLonBounds& b) {
  geo::LatLonBounds common{a.east_deg, std::max(a.south_deg, b.south_deg), a.west_deg,
                           std::min(a.north_deg, b.north_deg)};
  for (const double turn_deg : {-360.0, 0.0, 360.0}) {
    const double west_deg = std::max(a.west_deg, b.west_deg + turn_deg),
                 east_deg = std::min(a.east_deg, b.east_deg + turn_deg);
    if (west_deg >= east_deg) continue;
    common.west_deg = std::min(common.west_deg, west_deg);
    common.east_deg = std::max(common.east_deg, east_deg);
  }
  return common;
}

}  // namespace skyquilt::storage
