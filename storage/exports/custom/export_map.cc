#include "storage/exports/custom/export_map.h"

#include <gdal_priv.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/fringe_encoder.h"
#include "core/image/picture_codec.h"
#include "core/indices/band_expression.h"
#include "storage/exports/cog_writer.h"
#include "storage/exports/custom/boundary.h"
#include "storage/exports/custom/target_crs.h"
#include "storage/exports/fringe_tile.h"
#include "storage/exports/kmz_writer.h"
#include "storage/exports/pmtiles_writer.h"
#include "storage/exports/stored_tiles.h"
#include "storage/exports/warp_geotiff.h"
#include "storage/exports/warped/warp_tiles.h"
#include "storage/files/publish_file.h"
#include "storage/rasters/band_raster.h"
#include "storage/rasters/gdal_steps.h"
#include "storage/tilesets/mbtiles_reader.h"
#include "storage/tilesets/mbtiles_writer.h"
#include "storage/tilesets/tile_source.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

constexpr int kWebMercatorEpsg = 3857;

// Nothing beyond the boundary. False: nothing at all.
bool Cut(const std::vector<std::uint8_t>& inside, image::RgbaImage& tile) {
  bool is_covered = false;
  std::uint8_t* pixel = tile.rgba.data();
  for (std::size_t i = 0; i < inside.size(); ++i, pixel += 4) {
    if (inside[i] == 0) std::fill(pixel, pixel + 4, std::uint8_t{0});
    is_covered |= pixel[3] != 0;
  }
  return is_covered;
}

class Clip {
 public:
  Clip(const Boundary* boundary, int quality, int tile_size_px, image::TileEncoding encoding,
       MbtilesWriter& writer)
      : boundary_(boundary),
        quality_(quality),
        tile_size_px_(tile_size_px),
        encoding_(encoding),
        writer_(writer) {}

  Result<void> Take(const geo::TileId& tile, std::string_view bytes) {
    const auto format = image::PictureFormatOf(bytes);
    if (!format) return Error{ErrorCode::kCorrupt, "A stored tile is no picture. Make the map again.", ""};
    const Cover cover = CoverOf(tile);
    if (cover == Cover::kNone) return {};
    if (cover == Cover::kAll)
      return Put(tile, *format, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    SKYQUILT_TRY_ASSIGN(image::RgbaImage picture, DecodeTile(bytes, tile_size_px_));
    if (!Cut(inside_, picture)) return {};
    switch (encoding_) {
      case image::TileEncoding::kWebp:
        return Put(tile, image::PictureFormat::kWebp,
                   image::EncodeWebp(image::RowsOf(picture), static_cast<float>(quality_)));
      case image::TileEncoding::kJpegWebp:
        return Put(tile, image::PictureFormat::kWebp, image::EncodeFringe(picture, quality_));
      case image::TileEncoding::kJpegPng:
        return Put(tile, image::PictureFormat::kPng,
                   image::EncodePicture(std::move(picture), image::PictureFormat::kPng));
    }
    SKYQUILT_CHECK(false, "an encoding outside the list");
  }
  bool is_empty() const { return min_zoom_ > max_zoom_; }
  int min_zoom() const { return min_zoom_; }
  int max_zoom() const { return max_zoom_; }

 private:
  Cover CoverOf(const geo::TileId& tile) {
    if (boundary_ == nullptr) return Cover::kAll;
    if (!on_zoom_ || zoom_ != tile.z()) {
      on_zoom_.emplace(*boundary_, tile.z(), tile_size_px_);
      zoom_ = tile.z();
    }
    return on_zoom_->Mask(tile, inside_);
  }
  Result<void> Put(const geo::TileId& tile, image::PictureFormat format,
                   std::span<const std::uint8_t> bytes) {
    min_zoom_ = std::min(min_zoom_, tile.z());
    max_zoom_ = std::max(max_zoom_, tile.z());
    return writer_.Put(tile, format, bytes);
  }

  const Boundary* const boundary_;
  const int quality_;
  const int tile_size_px_;
  const image::TileEncoding encoding_;
  MbtilesWriter& writer_;
  std::optional<BoundaryOnZoom> on_zoom_;
  int zoom_ = 0;
  std::vector<std::uint8_t> inside_;
  int min_zoom_ = geo::kMaxZoom + 1;
  int max_zoom_ = -1;
};

// Of a finished MBTiles the tiles that lie within a boundary (null: all), down to a zoom, as another one.
// Tiles wholly within are copied byte for byte; those on the boundary are made transparent beyond it and
// encoded anew. Memory is one tile and the boundary.
Result<void> ClipTileset(const fs::path& mbtiles, const fs::path& path, const Boundary* boundary,
                         int max_zoom, int quality, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const auto reader, MbtilesReader::Open(mbtiles));
  const auto& metadata = reader->metadata();
  SKYQUILT_TRY_ASSIGN(const MapFacts facts, FactsOfTileset(metadata));
  SKYQUILT_TRY_ASSIGN(auto db, SqliteDb::Open(mbtiles, OpenMode::kReadOnlyImmutable));
  SKYQUILT_TRY_ASSIGN(const std::int64_t count, CountTiles(db));
  SKYQUILT_TRY_ASSIGN(auto writer, MbtilesWriter::Create(path));
  Clip clip(boundary, quality, facts.tile_size_px, EncodingOf(metadata), *writer);
  SKYQUILT_TRY_ASSIGN(auto walk, TileWalk::Of(db));
  for (std::int64_t done = 1;; ++done) {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The export was cancelled.", ""};
    SKYQUILT_TRY_ASSIGN(const bool more, walk.Next());
    if (!more || walk.tile().z() > max_zoom) break;
    SKYQUILT_TRY(clip.Take(walk.tile(), walk.bytes()));
    progress.Report(static_cast<double>(done) / static_cast<double>(count), "cutting tiles");
  }
  if (clip.is_empty())
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kExportNothingWithin);
  TilesetMetadata written;
  written.name = TilesetText(metadata, "name");
  written.description = TilesetText(metadata, "description");
  written.attribution = TilesetText(metadata, "attribution");
  written.generator = "Skyquilt";
  written.bounds = boundary == nullptr ? facts.bounds : Common(facts.bounds, boundary->Bounds()).OnEarth();
  written.min_zoom = clip.min_zoom();
  written.max_zoom = clip.max_zoom();
  written.tile_size_px = facts.tile_size_px;
  return writer->Publish(written);
}

constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint8_t kSolidAlpha = 128;  // as the tiles of an index have it

// Columns and rows of a zoom's tiles, the last ones included. Columns may lie beyond the antimeridian.
struct TileRange {
  std::int64_t left = 0, top = 0, right = 0, bottom = 0;
};

TileRange TilesOver(const geo::Bounds2& merc, int zoom) {
  constexpr double kOnEdge = 1e-6;  // of a tile
  const double side_m = geo::TileSizeInMercM(zoom), half_m = geo::kMercHalfWidthM;
  const auto first = [&](double metres) {
    return static_cast<std::int64_t>(std::floor(metres / side_m + kOnEdge));
  };
  const auto last = [&](double metres) {
    return static_cast<std::int64_t>(std::ceil(metres / side_m - kOnEdge)) - 1;
  };
  return {first(merc.min.x() + half_m), first(half_m - merc.max.y()), last(merc.max.x() + half_m),
          last(half_m - merc.min.y())};
}

// The pixels of these tiles.
MercGrid GridOf(const TileRange& range, const MapFacts& facts) {
  const double side_m = geo::TileSizeInMercM(facts.max_zoom);
  const double pixel_m = geo::PixelSizeInMercM(facts.max_zoom, facts.tile_size_px);
  return {static_cast<double>(range.left) * side_m - geo::kMercHalfWidthM,
          geo::kMercHalfWidthM - static_cast<double>(range.top) * side_m,
          pixel_m,
          pixel_m,
          static_cast<int>((range.right - range.left + 1) * facts.tile_size_px),
          static_cast<int>((range.bottom - range.top + 1) * facts.tile_size_px)};
}

struct IndexSource {
  MapTiles& tiles;
  fs::path bands;  // bands.tif; empty: the map has its colours alone
  MapFacts facts;
};

// The values of the bands that an expression reads, a plane each, over one tile.
class Planes {
 public:
  static Result<Planes> Of(const IndexSource& source, const indices::BandExpression& expression) {
    Planes planes(source);
    if (!source.bands.empty()) {
      SKYQUILT_TRY_ASSIGN(planes.raster_, BandRaster::Open(source.bands));
    }
    SKYQUILT_TRY_ASSIGN(planes.places_,
                        PlacesOf(expression, planes.raster_ ? planes.raster_->bands() : ColourBands()));
    return planes;
  }

  TileRange Range() const {
    const MapFacts& facts = source_->facts;
    return TilesOver(raster_ ? raster_->BoundsInMerc() : geo::MercFromLatLonBounds(facts.bounds),
                     facts.max_zoom);
  }

  // False: nothing is known there.
  Result<bool> Read(std::int64_t column, std::int64_t row, std::vector<std::vector<double>>& values) {
    const auto side = static_cast<std::size_t>(source_->facts.tile_size_px);
    values.assign(places_.size(), std::vector<double>(side * side, kNoValue));
    return raster_ ? ReadRaster(column, row, values) : ReadColours(column, row, values);
  }

 private:
  explicit Planes(const IndexSource& source) : source_(&source) {}

  Result<bool> ReadRaster(std::int64_t column, std::int64_t row, std::vector<std::vector<double>>& values) {
    SKYQUILT_TRY_ASSIGN(const std::vector<std::vector<float>> read,
                        raster_->Read(GridOf({column, row, column, row}, source_->facts), places_));
    for (std::size_t i = 0; i < read.size(); ++i)
      std::copy(read[i].begin(), read[i].end(), values[i].begin());
    return true;
  }

  Result<bool> ReadColours(std::int64_t column, std::int64_t row, std::vector<std::vector<double>>& values) {
    const int zoom = source_->facts.max_zoom;
    const std::int64_t around = std::int64_t{1} << zoom;
    SKYQUILT_TRY_ASSIGN(const geo::TileId tile,
                        geo::TileId::Make(zoom, (column % around + around) % around, row));
    SKYQUILT_TRY_ASSIGN(const std::optional<FoundTile> found, source_->tiles.Find(tile));
    if (!found) return false;
    SKYQUILT_TRY_ASSIGN(const std::string bytes, source_->tiles.Load(*found));
    SKYQUILT_TRY_ASSIGN(const image::RgbaImage picture, DecodeTile(bytes, source_->facts.tile_size_px));
    for (std::size_t i = 0; i < places_.size(); ++i) {
      for (std::size_t pixel = 0; pixel < values[i].size(); ++pixel) {
        const std::uint8_t* const rgba = picture.rgba.data() + 4 * pixel;
        if (rgba[3] >= kSolidAlpha) values[i][pixel] = rgba[places_[i]] / 255.0;
      }
    }
    return true;
  }

  const IndexSource* source_;
  std::shared_ptr<BandRaster> raster_;
  std::vector<std::size_t> places_;
};

// An index as a GeoTIFF of one band: float32, NaN where it has no value, in EPSG:3857 on the map's own
// pixels, described by the index's name or formula. The bands are those of bands.tif, or the map's own
// colours, 0 to 1, where it has none. Beyond `boundary` (null: none) nothing has a value. Tile by tile;
// memory: a tile and GDAL's block cache. Tiled and compressed without loss: a step on the way to a
// cloud-optimised one.
Result<void> WriteIndexGrid(const IndexSource& source, const indices::BandExpression& expression,
                            const std::string& name, const Boundary* boundary, const fs::path& path,
                            Progress& progress) {
  const MapFacts& facts = source.facts;
  const int side = facts.tile_size_px;
  SKYQUILT_TRY_ASSIGN(Planes planes, Planes::Of(source, expression));
  const TileRange range = planes.Range();
  SKYQUILT_TRY_ASSIGN(std::unique_ptr<GDALDataset> made,
                      CreateMercFloats(path, GridOf(range, facts), 1, progress));
  made->GetRasterBand(1)->SetDescription(name.c_str());
  made->GetRasterBand(1)->SetNoDataValue(kNoValue);
  std::optional<geo::BoundaryOnZoom> on_zoom;
  if (boundary != nullptr) on_zoom.emplace(*boundary, facts.max_zoom, side);
  std::vector<std::uint8_t> inside;
  std::vector<std::vector<double>> values;
  std::vector<float> index(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  bool has_value = false;
  const std::int64_t around = std::int64_t{1} << facts.max_zoom;
  for (std::int64_t row = range.top; row <= range.bottom; ++row) {
    progress.Report(static_cast<double>(row - range.top) / static_cast<double>(range.bottom - range.top + 1),
                    "values");
    if (progress.IsCancelled()) return LastGdalError(progress);
    for (std::int64_t column = range.left; column <= range.right; ++column) {
      SKYQUILT_TRY_ASSIGN(const geo::TileId tile,
                          geo::TileId::Make(facts.max_zoom, (column % around + around) % around, row));
      const geo::Cover cover = on_zoom ? on_zoom->Mask(tile, inside) : geo::Cover::kAll;
      if (cover == geo::Cover::kNone) continue;
      SKYQUILT_TRY_ASSIGN(const bool is_known, planes.Read(column, row, values));
      if (!is_known) continue;
      std::vector<const double*> rows;
      for (const std::vector<double>& plane : values) rows.push_back(plane.data());
      expression.Evaluate(rows, index);
      if (cover == geo::Cover::kPart) {
        for (std::size_t i = 0; i < index.size(); ++i) {
          if (inside[i] == 0) index[i] = kNoValue;
        }
      }
      const bool has_one =
          std::any_of(index.begin(), index.end(), [](float value) { return !std::isnan(value); });
      if (!has_one) continue;
      has_value = true;
      if (made->GetRasterBand(1)->RasterIO(GF_Write, static_cast<int>(column - range.left) * side,
                                           static_cast<int>(row - range.top) * side, side, side, index.data(),
                                           side, side, GDT_Float32, 0, 0, nullptr) != CE_None)
        return LastGdalError(progress);
    }
  }
  if (!IsClosedWell(std::move(made))) return LastGdalError(progress);
  if (has_value) return {};
  if (boundary != nullptr)
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kExportNothingWithin);
  return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kIndexWithoutValue);
}

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
    const Boundary* const boundary = request.boundary ? &*request.boundary : nullptr;
    const bool is_all = request.format == ExportFormat::kMbtiles;
    SKYQUILT_TRY(
        ClipTileset(source.mbtiles, is_all ? path : cut.path(), boundary, zoom, options.quality, progress));
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
