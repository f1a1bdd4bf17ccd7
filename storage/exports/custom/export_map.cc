#include "storage/exports/custom/export_map.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "storage/exports/cog_writer.h"
#include "storage/exports/custom/clip_tileset.h"
#include "storage/exports/custom/index_grid.h"
#include "storage/exports/custom/target_crs.h"
#include "storage/exports/kmz_writer.h"
#include "storage/exports/pmtiles_writer.h"
#include "storage/exports/warp_geotiff.h"
#include "storage/exports/warped/warp_tiles.h"
#include "storage/files/publish_file.h"
#include "storage/rasters/band_raster.h"
#include "storage/rasters/gdal_steps.h"
#include "storage/tilesets/mbtiles_reader.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

constexpr int kWebMercatorEpsg = 3857;

Result<void> CopyWhole(const fs::path& from, const fs::path& path) {
  const TemporaryFile copy(path, ".tmp");
  std::error_code error;
  fs::copy_file(from, copy.path(), fs::copy_options::overwrite_existing, error);
  if (error) return FileError("cannot write", copy.path(), error.value());
  return PublishFile(copy.path(), path);
}

// The pixel of a GeoTIFF, in metres on the ground: as wanted, or the photos', but none finer than is stored.
double PixelOf(const ExportRequest& request, const MapFacts& map) {
  return request.resolution_m ? *request.resolution_m : std::max(map.gsd_m, map.FinestPixelM());
}

geo::LatLonBounds BoundsOf(const ExportRequest& request, const MapFacts& map) {
  return request.boundary ? Common(map.bounds, request.boundary->Bounds()) : map.bounds;
}

Result<WarpTarget> TargetOf(const ExportRequest& request, const MapFacts& map) {
  SKYQUILT_TRY_ASSIGN(const int epsg, EpsgOf(request.crs, map.bounds.Middle()));
  SKYQUILT_TRY_ASSIGN(const TargetCrs crs, FindTargetCrs(epsg, BoundsOf(request, map).Middle()));
  const double pixel_m = PixelOf(request, map);
  return WarpTarget{epsg, pixel_m * crs.units_per_m_east, pixel_m * crs.units_per_m_north,
                    pixel_m > 1.5 * map.FinestPixelM()};
}

// In merc: where the values of an index lie. Bands may reach further than the map's tiles do.
Result<geo::Bounds2> ReachOfValues(const ExportRequest& request, const MapFacts& map, const fs::path& bands) {
  if (request.boundary || bands.empty()) return geo::MercFromLatLonBounds(BoundsOf(request, map));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<BandRaster> raster, BandRaster::Open(bands));
  return raster->BoundsInMerc();
}

Result<void> WriteIndex(const IndexSource& source, const ExportRequest& request, const fs::path& work_folder,
                        const fs::path& path, const ExportOptions& options, Progress& progress) {
  const TemporaryFile grid(work_folder / "index.tif", "");
  progress.BeginStage("gather");
  SKYQUILT_TRY(WriteIndexGrid(source, ExpressionOf(request), IndexNameOf(request),
                              request.boundary ? &*request.boundary : nullptr, grid.path(), progress));
  WarpOptions warp;
  SKYQUILT_TRY_ASSIGN(warp.target, TargetOf(request, source.facts));
  warp.pixels = WarpedPixels::kValues;
  warp.threads = options.threads;
  SKYQUILT_TRY_ASSIGN(const geo::Bounds2 reach, ReachOfValues(request, source.facts, source.bands));
  // A map across the antimeridian is cut by no such box.
  const bool is_in_one = reach.max.x() <= geo::kMercHalfWidthM;
  warp.bounds = is_in_one ? std::optional(geo::LatLonBoundsFromMerc(reach)) : std::nullopt;
  // The map's own pixels stay as they are.
  if (warp.target.epsg == kWebMercatorEpsg && !request.resolution_m) warp.window = reach;
  progress.BeginStage("export");
  return WarpGeotiff(grid.path(), path, warp, progress);
}

Result<void> WriteGeotiff(const fs::path& tiles, const fs::path& cog, const ExportRequest& request,
                          const MapFacts& map, const fs::path& path, const ExportOptions& options,
                          Progress& progress) {
  progress.BeginStage("export");
  if (IsAsStored(request))
    return cog.empty() ? WriteCog(tiles, path, {options.quality, options.threads}, progress)
                       : CopyWhole(cog, path);
  WarpTilesOptions warp;
  SKYQUILT_TRY_ASSIGN(warp.target, TargetOf(request, map));
  warp.bounds = BoundsOf(request, map);
  warp.min_zoom = map.min_zoom;
  warp.max_zoom = map.max_zoom;
  warp.jpeg_quality = options.quality;
  warp.threads = options.threads;
  SKYQUILT_TRY_ASSIGN(const auto reader, MbtilesReader::Open(tiles));
  return WarpTiles(*reader, path, warp, progress);
}

}  // namespace

Result<void> ExportMap(const ExportSource& source, const ExportRequest& request, const fs::path& work_folder,
                       const fs::path& path, const ExportOptions& options, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const auto reader, MbtilesReader::Open(source.mbtiles));
  SKYQUILT_TRY_ASSIGN(MapFacts map, FactsOfTileset(reader->metadata()));
  map.gsd_m = source.gsd_m;
  map.is_placed = source.is_placed;
  SKYQUILT_TRY(CheckExport(request, map));
  if (request.IsOfValues())
    return WriteIndex({*reader, source.bands, map}, request, work_folder, path, options, progress);
  const bool is_geotiff = request.format == ExportFormat::kGeotiff;
  const int zoom = is_geotiff ? map.max_zoom : ZoomOfExport(request, map);
  const bool is_cut = request.boundary.has_value() || zoom < map.max_zoom;
  const TemporaryFile cut(work_folder / "cut.mbtiles", "");
  if (is_cut) {
    progress.BeginStage("cut");
    const ClipOptions clip{request.boundary ? &*request.boundary : nullptr, zoom, options.quality};
    const bool is_all = request.format == ExportFormat::kMbtiles;
    SKYQUILT_TRY(ClipTileset(source.mbtiles, is_all ? path : cut.path(), clip, progress));
    if (is_all) return {};
  }
  const fs::path tiles = is_cut ? cut.path() : source.mbtiles;
  if (is_geotiff)
    return WriteGeotiff(tiles, is_cut ? fs::path() : source.cog, request, map, path, options, progress);
  progress.BeginStage("export");
  if (request.format == ExportFormat::kPmtiles) return WritePmtiles(tiles, path, progress);
  if (request.format == ExportFormat::kKmz) return WriteKmz(tiles, path, progress);
  return CopyWhole(tiles, path);
}

Result<ExportSource> ExportSourceOf(const fs::path& map) {
  std::error_code error;
  const bool is_folder = fs::is_directory(map, error);
  ExportSource source;
  source.mbtiles = is_folder ? map / "mosaic.mbtiles" : map;
  if (!fs::is_regular_file(source.mbtiles, error))
    return Error{
        ErrorCode::kNotFound,
        map.string() +
            " holds no finished map (mosaic.mbtiles). Name the folder that \"skyquilt stitch -o\" wrote, "
            "or an .mbtiles.",
        ""};
  const fs::path folder = source.mbtiles.parent_path();
  if (source.mbtiles.filename() != "mosaic.mbtiles") return source;
  if (fs::is_regular_file(folder / "mosaic.tif", error)) source.cog = folder / "mosaic.tif";
  if (fs::is_regular_file(folder / "bands.tif", error)) source.bands = folder / "bands.tif";
  const auto report = ParseJsonFile(folder / "report.json");
  if (!report.is_object()) return source;
  const auto gsd = report.find("gsd_m"), placed = report.find("is_placed");
  if (gsd != report.end() && gsd->is_number()) source.gsd_m = gsd->get<double>();
  if (placed != report.end() && placed->is_boolean()) source.is_placed = placed->get<bool>();
  return source;
}

Result<std::optional<flight::Remark>> RemarkOnExport(const ExportSource& source,
                                                     const ExportRequest& request) {
  SKYQUILT_TRY_ASSIGN(const auto reader, MbtilesReader::Open(source.mbtiles));
  SKYQUILT_TRY_ASSIGN(const MapFacts facts, FactsOfTileset(reader->metadata()));
  return RemarkOnCrs(request.crs, facts.bounds.Middle());
}

Result<double> PixelsOfExport(const fs::path& map, const ExportRequest& request) {
  SKYQUILT_TRY_ASSIGN(const ExportSource source, ExportSourceOf(map));
  SKYQUILT_TRY_ASSIGN(const auto reader, MbtilesReader::Open(source.mbtiles));
  SKYQUILT_TRY_ASSIGN(const MapFacts facts, FactsOfTileset(reader->metadata()));
  SKYQUILT_TRY_ASSIGN(const geo::Bounds2 reach, ReachOfValues(request, facts, source.bands));
  const double pixel_m = geo::PixelSizeInMercM(facts.max_zoom, facts.tile_size_px);
  return std::max(reach.Width(), 0.0) * std::max(reach.Height(), 0.0) / (pixel_m * pixel_m);
}

}  // namespace skyquilt::storage
