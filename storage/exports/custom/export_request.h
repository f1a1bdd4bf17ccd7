// ExportRequest: how somebody wants a finished map: format, coordinate system, area, resolution. CheckExport
// says what of it cannot be, before any work. A report is no other form of the tiles but a page about the
// map, which whoever serves it prints (server/reports). Pure but for PROJ's database; any thread. Errors:
// kInvalidArgument (not JSON), kUnprocessable (a field that is unknown, of a wrong kind, or that this map
// cannot serve; the message says what to ask for instead), kCorrupt (a tileset without bounds or zooms).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/indices/band_expression.h"
#include "storage/exports/custom/boundary.h"

namespace skyquilt::storage {

enum class ExportFormat { kGeotiff, kPmtiles, kMbtiles, kKmz, kReport };

// "geotiff", and the ending of such a file: "tif".
const char* NameOf(ExportFormat format);
const char* EndingOf(ExportFormat format);
const char* ContentTypeOf(ExportFormat format);
std::optional<ExportFormat> ExportFormatOfName(std::string_view name);
// Of "map.tif", "MAP.TIFF", "map.pmtiles"; none for a report, which is no form of the tiles.
std::optional<ExportFormat> ExportFormatOfFile(std::string_view file_name);

struct ExportRequest {
  ExportFormat format = ExportFormat::kGeotiff;
  std::string crs;  // "EPSG:2056", its URN, "utm"; empty: Web Mercator, as the map is served
  std::optional<Boundary> boundary;
  std::optional<double> resolution_m;  // of a pixel, on the ground
  // Of a GeoTIFF: its values instead of colours (core/indices); at most one of the two.
  std::string index;       // "ndvi"
  std::string expression;  // "(nir-red)/(nir+red)"

  std::string name;  // of a report: what its map is called

  bool IsOfValues() const { return !index.empty() || !expression.empty(); }
};
// What an index calls itself, and how it is computed. Precondition: IsOfValues, as ParseExportRequest checks
// it.
std::string IndexNameOf(const ExportRequest& request);
indices::BandExpression ExpressionOf(const ExportRequest& request);

// {"format":"geotiff","crs":"EPSG:2056","boundary":{...},"resolution_m":0.1,"index":"ndvi"}
Result<ExportRequest> ParseExportRequest(std::string_view json);
// A GeoTIFF on the web map's own pixels: nothing of it is resampled.
bool IsAsStored(const ExportRequest& request);
// "utm", or the code of "EPSG:2056" and "urn:ogc:def:crs:EPSG::2056". Error: kUnprocessable.
Result<int> EpsgOf(const std::string& crs, const geo::LatLon& middle);
// What is to be known of a file in that system: that its datum's place on Earth is not known to a metre.
std::optional<flight::Remark> RemarkOnCrs(const std::string& crs, const geo::LatLon& middle);

// What a finished map is, as far as exports depend on it.
struct MapFacts {
  geo::LatLonBounds bounds;
  int min_zoom = 0;
  int max_zoom = 0;
  int tile_size_px = 256;
  double gsd_m = 0.0;     // of its photos; 0: not known
  bool is_placed = true;  // it lies where it belongs on Earth

  // Of the finest stored pixel, on the ground.
  double PixelM(int zoom) const;
  double FinestPixelM() const { return PixelM(max_zoom); }
};

Result<MapFacts> FactsOfTileset(const std::map<std::string, std::string>& metadata);

Result<void> CheckExport(const ExportRequest& request, const MapFacts& map);
// The zoom down to which a tileset is exported: the coarsest whose pixels are not larger than asked for.
int ZoomOfExport(const ExportRequest& request, const MapFacts& map);

// What both cover, as the numbers of `a` go: across the antimeridian `b` may lie a turn off, or in two parts
// at both ends of the Earth. Of two that do not meet, something without area.
geo::LatLonBounds Common(const geo::LatLonBounds& a, const geo::LatLonBounds& b);

}  // namespace skyquilt::storage
