#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/pyramid/build_overviews.h"
#include "core/pyramid/encode_tile.h"
#include "server/imports/imported_tileset.h"
#include "storage/rasters/map_raster.h"
#include "storage/tilesets/mbtiles_writer.h"

namespace skyquilt::server {
namespace {

// Tiles are read in squares of so many a side (a power of two): GDAL's blocks are then read about once.
constexpr int kBlockOrder = 2;

struct TilePlace {
  int column = 0, row = 0;
};

// What lies within a range of columns and rows, along the Hilbert curve of a zoom.
std::vector<TilePlace> AlongHilbert(int zoom, TilePlace first, TilePlace last) {
  std::vector<std::pair<std::uint64_t, TilePlace>> ordered;
  for (int row = first.row; row <= last.row; ++row) {
    for (int column = first.column; column <= last.column; ++column) {
      ordered.push_back(
          {geo::HilbertIndex(zoom, static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row)),
           {column, row}});
    }
  }
  std::sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<TilePlace> places;
  places.reserve(ordered.size());
  for (const auto& [index, place] : ordered) places.push_back(place);
  return places;
}

image::RgbaImage Square(const image::RgbaImage& image, int left, int top, int side_px) {
  image::RgbaImage square = image::RgbaImage::Transparent(side_px, side_px);
  for (int y = 0; y < side_px; ++y)
    std::copy_n(image.Pixel(left, top + y), static_cast<std::ptrdiff_t>(side_px) * 4, square.Pixel(0, y));
  return square;
}

// Pixels that are covered: how many, and within which columns and rows.
struct Covered {
  std::int64_t count = 0;
  std::int64_t first_x = 0, last_x = 0, first_y = 0, last_y = 0;

  void Include(std::int64_t x, std::int64_t y) {
    if (count++ == 0) first_x = last_x = x, first_y = last_y = y;
    first_x = std::min(first_x, x);
    last_x = std::max(last_x, x);
    first_y = std::min(first_y, y);
    last_y = std::max(last_y, y);
  }
};

int CoarsestZoom(const storage::MapRaster& raster) {
  int zoom = raster.zoom();
  int first_column = raster.first_column(), last_column = raster.last_column();
  int first_row = raster.first_row(), last_row = raster.last_row();
  while (zoom > 0 && (first_column != last_column || first_row != last_row)) {
    --zoom;
    for (int* edge : {&first_column, &last_column, &first_row, &last_row}) *edge >>= 1;
  }
  return zoom;
}

class RasterTiles {
 public:
  RasterTiles(storage::MapRaster& raster, storage::MbtilesWriter& writer, const ImportOptions& options)
      : raster_(raster),
        writer_(writer),
        encode_{.quality = options.quality},
        overviews_(raster.zoom(), CoarsestZoom(raster), raster.tile_size_px(),
                   [this](const geo::TileId& tile, const image::RgbaImage& image) { Put(tile, image); }) {}

  Result<void> TakeAll(Progress& progress) {
    const int zoom = raster_.zoom(), order = std::min(kBlockOrder, zoom), side = 1 << order;
    const std::vector<TilePlace> blocks =
        AlongHilbert(zoom - order, {raster_.first_column() >> order, raster_.first_row() >> order},
                     {raster_.last_column() >> order, raster_.last_row() >> order});
    for (std::size_t done = 0; done < blocks.size(); ++done) {
      if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The import was cancelled."};
      const TilePlace corner{blocks[done].column << order, blocks[done].row << order};
      SKYQUILT_TRY_ASSIGN(const image::RgbaImage block, raster_.Read(corner.column, corner.row, side, side));
      for (const TilePlace& at :
           AlongHilbert(zoom, corner, {corner.column + side - 1, corner.row + side - 1}))
        Take(at, Square(block, (at.column - corner.column) * raster_.tile_size_px(),
                        (at.row - corner.row) * raster_.tile_size_px(), raster_.tile_size_px()));
      if (failure_) return *failure_;
      progress.Report(static_cast<double>(done + 1) / static_cast<double>(blocks.size()), "cutting tiles");
    }
    overviews_.Finish();
    return failure_ ? Result<void>(*failure_) : Result<void>();
  }
  std::int64_t tiles() const { return tiles_; }
  const Covered& covered() const { return covered_; }

 private:
  void Take(const TilePlace& at, const image::RgbaImage& image) {
    const std::int64_t before = covered_.count;
    const std::int64_t left = std::int64_t{at.column} * image.width_px,
                       top = std::int64_t{at.row} * image.height_px;
    for (int y = 0; y < image.height_px; ++y) {
      for (int x = 0; x < image.width_px; ++x) {
        if (image.Pixel(x, y)[3] != 0) covered_.Include(left + x, top + y);
      }
    }
    if (covered_.count == before) return;
    const geo::TileId tile = *geo::TileId::Make(raster_.zoom(), at.column, at.row);
    Put(tile, image);
    overviews_.Add(tile, image);
  }
  void Put(const geo::TileId& tile, const image::RgbaImage& image) {
    const auto encoded = pyramid::EncodeTile(image, encode_);
    if (!encoded || failure_) return;
    ++tiles_;
    const Result<void> put = writer_.Put(tile, encoded->format, encoded->bytes);
    if (!put) failure_ = put.error();
  }

  storage::MapRaster& raster_;
  storage::MbtilesWriter& writer_;
  const pyramid::EncodeOptions encode_;
  std::optional<Error> failure_;
  std::int64_t tiles_ = 0;
  Covered covered_;
  pyramid::OverviewBuilder overviews_;
};

}  // namespace

Result<void> ImportRaster(const flight::InputFile& file, const std::filesystem::path& mbtiles,
                          const ImportOptions& options, pipeline::MosaicReport& report, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const auto raster, storage::MapRaster::Open(file.path, file.name));
  SKYQUILT_TRY_ASSIGN(const auto writer, storage::MbtilesWriter::Create(mbtiles));
  RasterTiles tiles(*raster, *writer, options);
  SKYQUILT_TRY(tiles.TakeAll(progress));
  if (tiles.tiles() == 0)
    return flight::Because(ErrorCode::kUnprocessable,
                           {flight::RemarkCode::kImportTransparent, {{"file", file.name}}});
  report.min_zoom = CoarsestZoom(*raster);
  report.max_zoom = raster->zoom();
  report.tile_size_px = raster->tile_size_px();
  report.tile_count = tiles.tiles();
  report.gsd_m = raster->pixel_m();
  const double pixel_merc_m = geo::PixelSizeInMercM(report.max_zoom, report.tile_size_px);
  const Covered& covered = tiles.covered();
  const auto corner = [&](std::int64_t x, std::int64_t y) {
    return Eigen::Vector2d(static_cast<double>(x) * pixel_merc_m - geo::kMercHalfWidthM,
                           geo::kMercHalfWidthM - static_cast<double>(y) * pixel_merc_m);
  };
  report.bounds = geo::LatLonBoundsFromMerc(
      {corner(covered.first_x, covered.last_y + 1), corner(covered.last_x + 1, covered.first_y)});
  report.area_m2 = static_cast<double>(covered.count) * pixel_merc_m * pixel_merc_m *
                   geo::GroundPerMercArea(report.bounds.Middle().lat_deg);
  return writer->Publish(MetadataOfImport(report, ""));
}

}  // namespace skyquilt::server
