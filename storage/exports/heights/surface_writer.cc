#include "storage/exports/heights/surface_writer.h"

#include <cpl_error.h>
#include <fmt/core.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/try.h"
#include "storage/exports/warp_geotiff.h"
#include "storage/exports/warped/warp_tiles.h"
#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kWritingHeights = "writing dsm.tif";
constexpr const char* kWritingGround = "writing dtm.tif";
constexpr int kBlockCells = 512;
constexpr double kMeanRadiusM = 6'371'000.0;
// The Earth bends away from the frame's plane, by a square; between places so far apart a line follows it to
// a tenth of a millimetre.
constexpr int kCellsBetweenBends = 256;

std::unique_ptr<GDALDataset> CreateRaw(const char* path, const surface::SurfaceGrid& grid, GDALDataType type,
                                       OGRSpatialReference& system, const std::array<double, 6>& transform) {
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  SKYQUILT_CHECK(driver != nullptr, "GDAL writes GeoTIFF");
  CPLStringList options;
  AddGdalWords(options, {"TILED=YES", "BLOCKXSIZE=512", "BLOCKYSIZE=512", "COMPRESS=ZSTD", "ZSTD_LEVEL=1",
                         "SPARSE_OK=TRUE", "BIGTIFF=IF_SAFER"});
  std::unique_ptr<GDALDataset> dataset(
      driver->Create(path, grid.columns, grid.rows, 1, type, options.List()));
  std::array<double, 6> copy = transform;
  if (!dataset || dataset->SetSpatialRef(&system) != CE_None ||
      dataset->SetGeoTransform(copy.data()) != CE_None)
    return nullptr;
  return dataset;
}

bool ReadOrWrite(GDALRWFlag way, GDALDataset& raster, const surface::CellBox& box, void* values,
                 GDALDataType type) {
  return raster.GetRasterBand(1)->RasterIO(way, box.column, box.row, box.columns, box.rows, values,
                                           box.columns, box.rows, type, 0, 0, nullptr) == CE_None;
}

}  // namespace

struct SurfaceWriter::Work {
  std::filesystem::path folder;
  geo::LocalFrame frame;
  geo::LatLon map_middle;
  surface::SurfaceGrid grid;
  double mean_z_m;
  int threads;
  Progress& progress;
  TemporaryTiff raw_heights, raw_photos, raw_ground, raw_seen;
  std::unique_ptr<GDALDataset> heights, photos, ground, seen;
  surface::GroundBelow* below;  // null: the ground is not wanted
  double raised_m = 0.0;
  std::int64_t shown = 0, measured = 0;

  // Metres above the zero of heights of a place of the frame's plane.
  double BendAt(const Eigen::Vector2d& east_north) const {
    return frame.Wgs84FromEnu({east_north.x(), east_north.y(), mean_z_m}).height_ellipsoid_m - mean_z_m +
           raised_m;
  }
  // What to add to the block's heights, by cell.
  std::vector<double> BendsOf(const surface::CellBox& box) const;
  // Once all heights are there.
  Result<void> PutGround();
  Result<void> PublishAs(const char* name, const TemporaryTiff& raw, WarpedPixels pixels, int epsg,
                         const char* message) const;
};

Result<void> SurfaceWriter::Work::PutGround() {
  below->Finish();
  for (int row = 0; row < grid.rows; row += kBlockCells) {
    for (int column = 0; column < grid.columns; column += kBlockCells) {
      const surface::CellBox box{column, row, std::min(kBlockCells, grid.columns - column),
                                 std::min(kBlockCells, grid.rows - row)};
      std::vector<float> heights_m(box.Count());
      std::vector<std::uint8_t> agreeing(box.Count());
      if (!ReadOrWrite(GF_Read, *heights, box, heights_m.data(), GDT_Float32) ||
          !ReadOrWrite(GF_Read, *photos, box, agreeing.data(), GDT_Byte))
        return LastGdalError(progress);
      surface::GroundModel under = below->GroundOf(box, heights_m, agreeing);
      if (!ReadOrWrite(GF_Write, *ground, box, under.heights_m.data(), GDT_Float32) ||
          !ReadOrWrite(GF_Write, *seen, box, under.is_ground.data(), GDT_Byte))
        return LastGdalError(progress);
    }
  }
  return {};
}

Result<void> SurfaceWriter::Work::PublishAs(const char* name, const TemporaryTiff& raw, WarpedPixels pixels,
                                            int epsg, const char* message) const {
  WarpOptions warp;
  warp.target.epsg = epsg;
  warp.target.pixel_x = warp.target.pixel_y = grid.cell_m;
  warp.threads = threads;
  warp.message = message;
  warp.pixels = pixels;
  return WarpGeotiff(raw.path(), folder / name, warp, progress);
}

std::vector<double> SurfaceWriter::Work::BendsOf(const surface::CellBox& box) const {
  std::vector<double> bends(box.Count());
  for (int low = 0; low < box.rows; low += kCellsBetweenBends) {
    for (int left = 0; left < box.columns; left += kCellsBetweenBends) {
      const auto at = [&](int column, int row) {
        return BendAt(grid.south_west_in_enu +
                      grid.cell_m * Eigen::Vector2d(box.column + column, box.row + row));
      };
      const int right = left + kCellsBetweenBends, high = low + kCellsBetweenBends;
      const double corners[] = {at(left, low), at(right, low), at(left, high), at(right, high)};
      for (int row = low; row < std::min(high, box.rows); ++row) {
        const double v = static_cast<double>(row - low) / kCellsBetweenBends;
        const double first = corners[0] + v * (corners[2] - corners[0]),
                     last = corners[1] + v * (corners[3] - corners[1]);
        double* to = bends.data() + static_cast<std::ptrdiff_t>(row) * box.columns;
        for (int column = left; column < std::min(right, box.columns); ++column) {
          const double u = static_cast<double>(column - left) / kCellsBetweenBends;
          to[column] = first + u * (last - first);
        }
      }
    }
  }
  return bends;
}

SurfaceWriter::SurfaceWriter(const std::filesystem::path& folder, const geo::LocalFrame& frame,
                             const geo::LatLon& map_middle, const surface::SurfaceGrid& grid, double mean_z_m,
                             int threads, surface::GroundBelow* ground, Progress& progress, double raised_m)
    : work_(new Work{folder,
                     frame,
                     map_middle,
                     grid,
                     mean_z_m,
                     threads,
                     progress,
                     {folder / "dsm.tif", ".raw.tmp"},
                     {folder / "dsm_photos.tif", ".raw.tmp"},
                     {folder / "dtm.tif", ".raw.tmp"},
                     {folder / "dtm_ground.tif", ".raw.tmp"},
                     nullptr,
                     nullptr,
                     nullptr,
                     nullptr,
                     ground,
                     raised_m}) {}
SurfaceWriter::~SurfaceWriter() = default;

Result<void> SurfaceWriter::Begin() {
  RegisterGdalOnce();
  CPLErrorReset();
  Work& work = *work_;
  const geo::Wgs84& origin = work.frame.origin();
  SKYQUILT_TRY(UtmEpsg(work.map_middle));
  // East and north of the frame are, but for what the height above the ellipsoid adds, those of the azimuthal
  // projection about its origin: 0.5 mm off at 5 km. The orthographic one, which has no such bend, knows half
  // of the Earth only, of which GDAL complains.
  OGRSpatialReference system;
  system.importFromProj4(fmt::format("+proj=aeqd +lat_0={:.12f} +lon_0={:.12f} +datum=WGS84 +units=m",
                                     origin.lat_deg, origin.lon_deg)
                             .c_str());
  const double scale = 1.0 / (1.0 + (origin.height_ellipsoid_m + work.mean_z_m) / kMeanRadiusM);
  const surface::SurfaceGrid& grid = work.grid;
  const double cell_m = scale * grid.cell_m;
  const Eigen::Vector2d corner =
      scale * (grid.south_west_in_enu - 0.5 * grid.cell_m * Eigen::Vector2d::Ones());
  const std::array<double, 6> transform = {corner.x(), cell_m, 0.0, corner.y() + grid.rows * cell_m,
                                           0.0,        -cell_m};
  work.heights = CreateRaw(work.raw_heights.c_str(), grid, GDT_Float32, system, transform);
  work.photos = CreateRaw(work.raw_photos.c_str(), grid, GDT_Byte, system, transform);
  if (work.below) {
    work.ground = CreateRaw(work.raw_ground.c_str(), grid, GDT_Float32, system, transform);
    work.seen = CreateRaw(work.raw_seen.c_str(), grid, GDT_Byte, system, transform);
  }
  if (!work.heights || !work.photos || (work.below && (!work.ground || !work.seen)))
    return LastGdalError(work.progress);
  for (GDALDataset* raster : {work.heights.get(), work.ground.get()}) {
    if (raster != nullptr &&
        raster->GetRasterBand(1)->SetNoDataValue(std::numeric_limits<double>::quiet_NaN()) != CE_None)
      return LastGdalError(work.progress);
  }
  return {};
}

Result<void> SurfaceWriter::Put(const surface::SurfaceBlock& block) {
  Work& work = *work_;
  const surface::CellBox& box = block.box;
  const std::vector<double> bends = work.BendsOf(box);
  std::vector<float> heights(box.Count());
  std::vector<std::uint8_t> photos(box.Count());
  for (int row = 0; row < box.rows; ++row) {
    const std::size_t from = static_cast<std::size_t>(row) * box.columns,
                      to = static_cast<std::size_t>(box.rows - 1 - row) * box.columns;  // north is up
    for (std::size_t column = 0; column < static_cast<std::size_t>(box.columns); ++column) {
      const float height_m = block.cells.heights_m[from + column];
      heights[to + column] = static_cast<float>(height_m + bends[from + column]);
      photos[to + column] = block.cells.agreeing_photos[from + column];
      work.shown += std::isnan(height_m) ? 0 : 1;
      work.measured += photos[to + column] != 0 ? 1 : 0;
    }
  }
  const surface::CellBox from_north{box.column, work.grid.rows - box.row - box.rows, box.columns, box.rows};
  if (work.below) work.below->Add(from_north, heights, photos);
  if (!ReadOrWrite(GF_Write, *work.heights, from_north, heights.data(), GDT_Float32) ||
      !ReadOrWrite(GF_Write, *work.photos, from_north, photos.data(), GDT_Byte))
    return LastGdalError(work.progress);
  return {};
}

Result<void> SurfaceWriter::Publish() {
  Work& work = *work_;
  SKYQUILT_CHECK(work.heights && work.photos, "heights are published once, after Begin");
  if (work.below) SKYQUILT_TRY(work.PutGround());
  for (std::unique_ptr<GDALDataset>* raster : {&work.heights, &work.photos, &work.ground, &work.seen}) {
    if (*raster && !IsClosedWell(std::move(*raster))) return LastGdalError(work.progress);
  }
  SKYQUILT_TRY_ASSIGN(const int epsg, UtmEpsg(work.map_middle));
  SKYQUILT_TRY(work.PublishAs("dsm.tif", work.raw_heights, WarpedPixels::kHeights, epsg, kWritingHeights));
  SKYQUILT_TRY(
      work.PublishAs("dsm_photos.tif", work.raw_photos, WarpedPixels::kCounts, epsg, kWritingHeights));
  if (!work.below) return {};
  SKYQUILT_TRY(work.PublishAs("dtm.tif", work.raw_ground, WarpedPixels::kHeights, epsg, kWritingGround));
  return work.PublishAs("dtm_ground.tif", work.raw_seen, WarpedPixels::kCounts, epsg, kWritingGround);
}

double SurfaceWriter::MeasuredShare() const {
  return work_->shown == 0 ? 0.0 : static_cast<double>(work_->measured) / static_cast<double>(work_->shown);
}

}  // namespace skyquilt::storage
