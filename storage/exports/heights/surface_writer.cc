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
#include "core/flight/remarks/because.h"
#include "storage/exports/warp_geotiff.h"
#include "storage/exports/warped/warp_tiles.h"
#include "storage/files/publish_file.h"
#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {
namespace {

// The files that are written, those of the ground on request alone.
struct SurfaceFileFacts {
  const char* name;
  GDALDataType type;
  WarpedPixels pixels;
  const char* message;
};
constexpr std::array kSurfaceFiles = {
    SurfaceFileFacts{"dsm.tif", GDT_Float32, WarpedPixels::kHeights, "writing dsm.tif"},
    SurfaceFileFacts{"dsm_photos.tif", GDT_Byte, WarpedPixels::kCounts, "writing dsm.tif"},
    SurfaceFileFacts{"dtm.tif", GDT_Float32, WarpedPixels::kHeights, "writing dtm.tif"},
    SurfaceFileFacts{"dtm_ground.tif", GDT_Byte, WarpedPixels::kCounts, "writing dtm.tif"}};

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
  enum Place : std::size_t { kHeights, kPhotos, kGround, kSeen };  // in kSurfaceFiles
  std::filesystem::path folder;
  geo::LocalFrame frame;
  geo::LatLon map_middle;
  surface::SurfaceGrid grid;
  double mean_z_m;
  int threads;
  Progress& progress;
  std::array<TemporaryFile, kSurfaceFiles.size()> raw;
  surface::GroundBelow* below;  // null: the ground is not wanted
  std::array<std::unique_ptr<GDALDataset>, kSurfaceFiles.size()> rasters = {};
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
  std::size_t FileCount() const { return below != nullptr ? kSurfaceFiles.size() : std::size_t{kGround}; }
};

Result<void> SurfaceWriter::Work::PutGround() {
  below->Finish();
  for (int row = 0; row < grid.rows; row += kBlockCells) {
    for (int column = 0; column < grid.columns; column += kBlockCells) {
      const surface::CellBox box{column, row, std::min(kBlockCells, grid.columns - column),
                                 std::min(kBlockCells, grid.rows - row)};
      std::vector<float> heights_m(box.Count());
      std::vector<std::uint8_t> agreeing(box.Count());
      if (!ReadOrWrite(GF_Read, *rasters[kHeights], box, heights_m.data(), GDT_Float32) ||
          !ReadOrWrite(GF_Read, *rasters[kPhotos], box, agreeing.data(), GDT_Byte))
        return LastGdalError(progress);
      surface::GroundModel under = below->GroundOf(box, heights_m, agreeing);
      if (!ReadOrWrite(GF_Write, *rasters[kGround], box, under.heights_m.data(), GDT_Float32) ||
          !ReadOrWrite(GF_Write, *rasters[kSeen], box, under.is_ground.data(), GDT_Byte))
        return LastGdalError(progress);
    }
  }
  return {};
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
    : work_(new Work{.folder = folder,
                     .frame = frame,
                     .map_middle = map_middle,
                     .grid = grid,
                     .mean_z_m = mean_z_m,
                     .threads = threads,
                     .progress = progress,
                     .raw = {{{folder / kSurfaceFiles[0].name, ".raw.tmp"},
                              {folder / kSurfaceFiles[1].name, ".raw.tmp"},
                              {folder / kSurfaceFiles[2].name, ".raw.tmp"},
                              {folder / kSurfaceFiles[3].name, ".raw.tmp"}}},
                     .below = ground,
                     .raised_m = raised_m}) {}
SurfaceWriter::~SurfaceWriter() = default;

Result<void> SurfaceWriter::Begin() {
  RegisterGdalOnce();
  CPLErrorReset();
  Work& work = *work_;
  const geo::Wgs84& origin = work.frame.origin();
  SKYQUILT_TRY(UtmEpsg(work.map_middle));
  // A file of all that lies between fields far apart takes days, and a disk.
  constexpr double kMaxSpannedCells = 1e11;
  if (static_cast<double>(work.grid.columns) * work.grid.rows > kMaxSpannedCells)
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFieldsFarApart);
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
  for (std::size_t i = 0; i < work.FileCount(); ++i) {
    const GDALDataType type = kSurfaceFiles[i].type;
    work.rasters[i] = CreateRaw(work.raw[i].c_str(), grid, type, system, transform);
    if (!work.rasters[i]) return LastGdalError(work.progress);
    if (type == GDT_Float32 && work.rasters[i]->GetRasterBand(1)->SetNoDataValue(
                                   std::numeric_limits<double>::quiet_NaN()) != CE_None)
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
  if (!ReadOrWrite(GF_Write, *work.rasters[Work::kHeights], from_north, heights.data(), GDT_Float32) ||
      !ReadOrWrite(GF_Write, *work.rasters[Work::kPhotos], from_north, photos.data(), GDT_Byte))
    return LastGdalError(work.progress);
  return {};
}

Result<void> SurfaceWriter::Publish() {
  Work& work = *work_;
  SKYQUILT_CHECK(work.rasters[Work::kHeights] && work.rasters[Work::kPhotos],
                 "heights are published once, after Begin");
  if (work.below) SKYQUILT_TRY(work.PutGround());
  for (std::unique_ptr<GDALDataset>& raster : work.rasters) {
    if (raster && !IsClosedWell(std::move(raster))) return LastGdalError(work.progress);
  }
  WarpOptions warp;
  SKYQUILT_TRY_ASSIGN(warp.target.epsg, UtmEpsg(work.map_middle));
  warp.target.pixel_x = warp.target.pixel_y = work.grid.cell_m;
  warp.threads = work.threads;
  for (std::size_t i = 0; i < work.FileCount(); ++i) {
    warp.message = kSurfaceFiles[i].message;
    warp.pixels = kSurfaceFiles[i].pixels;
    // In place of the raw one, whose room it takes.
    SKYQUILT_TRY(WarpGeotiff(work.raw[i].path(), work.raw[i].path(), warp, work.progress));
  }
  // Once all are there: heights beside flags of an earlier map would pass for measured.
  for (std::size_t i = 0; i < work.FileCount(); ++i)
    SKYQUILT_TRY(PublishFile(work.raw[i].path(), work.folder / kSurfaceFiles[i].name));
  return {};
}

double SurfaceWriter::MeasuredShare() const {
  return work_->shown == 0 ? 0.0 : static_cast<double>(work_->measured) / static_cast<double>(work_->shown);
}

}  // namespace skyquilt::storage
