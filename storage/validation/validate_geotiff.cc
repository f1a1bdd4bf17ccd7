// Layout of cloud-optimised GeoTIFFs: OGC 21-026 and the rules of GDAL's validate_cloud_optimized_geotiff.
#include <cpl_error.h>
#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <system_error>
#include <vector>

#include "storage/rasters/gdal_steps.h"
#include "storage/validation/validate_map.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

constexpr int kLargestWithoutOverviews = 512;

std::optional<std::uint64_t> TiffNumber(GDALRasterBand& band, const std::string& item) {
  const char* text = band.GetMetadataItem(item.c_str(), "TIFF");
  if (text == nullptr) return std::nullopt;
  return std::strtoull(text, nullptr, 10);
}

struct Level {
  GDALRasterBand* band = nullptr;
  int block_width = 0, block_height = 0;
  std::string name;
};

std::vector<Level> LevelsOf(GDALDataset& raster) {
  std::vector<Level> levels;
  GDALRasterBand* full = raster.GetRasterBand(1);
  for (int i = -1; i < full->GetOverviewCount(); ++i) {
    Level level;
    level.band = i < 0 ? full : full->GetOverview(i);
    if (level.band == nullptr) continue;
    level.band->GetBlockSize(&level.block_width, &level.block_height);
    level.name = i < 0 ? "the full picture" : fmt::format("overview {}", i + 1);
    levels.push_back(level);
  }
  return levels;
}

void JudgeGeoreference(GDALDataset& raster, FileVerdict& verdict) {
  std::array<double, 6> t{};
  const bool has_place = raster.GetGeoTransform(t.data()) == CE_None;
  const OGRSpatialReference* reference = raster.GetSpatialRef();
  if (!has_place) verdict.Add(Severity::kError, "it is not georeferenced: it does not say where it lies");
  if (reference == nullptr || reference->IsEmpty()) {
    verdict.Add(Severity::kError, "it does not say its coordinate system");
    return;
  }
  if (!has_place) return;
  OGRSpatialReference wgs84;
  wgs84.SetWellKnownGeogCS("WGS84");
  wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  OGRSpatialReference own(*reference);
  own.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> to_wgs84(
      OGRCreateCoordinateTransformation(&own, &wgs84));
  const double width = raster.GetRasterXSize(), height = raster.GetRasterYSize();
  // The corners, and the middle.
  std::array<double, 5> x{t[0], t[0] + width * t[1], t[0] + height * t[2],
                          t[0] + width * t[1] + height * t[2], t[0] + 0.5 * (width * t[1] + height * t[2])};
  std::array<double, 5> y{t[3], t[3] + width * t[4], t[3] + height * t[5],
                          t[3] + width * t[4] + height * t[5], t[3] + 0.5 * (width * t[4] + height * t[5])};
  if (!to_wgs84 || !to_wgs84->Transform(5, x.data(), y.data()) ||
      !std::all_of(x.begin(), x.end(), [](double v) { return std::isfinite(v); }) ||
      !std::all_of(y.begin(), y.end(), [](double v) { return std::isfinite(v) && std::abs(v) <= 90.1; })) {
    verdict.Add(Severity::kError, "it lies where its coordinate system has no places on Earth");
    return;
  }
  // Across the antimeridian they go on as the middle has it.
  constexpr double kHalfTurnDeg = 180.0 + 1e-6;
  for (double& lon_deg : x) {
    if (lon_deg - x[4] > kHalfTurnDeg) lon_deg -= 360.0;
    if (x[4] - lon_deg > kHalfTurnDeg) lon_deg += 360.0;
  }
  const geo::LatLonBounds around{*std::min_element(x.begin(), x.end()), *std::min_element(y.begin(), y.end()),
                                 *std::max_element(x.begin(), x.end()),
                                 *std::max_element(y.begin(), y.end())};
  verdict.bounds = around.OnEarth();
}

void JudgeTiling(const std::vector<Level>& levels, Severity layout, FileVerdict& verdict) {
  const Level& full = levels.front();
  const int width = full.band->GetXSize(), height = full.band->GetYSize();
  const bool is_large = std::max(width, height) > kLargestWithoutOverviews;
  if (is_large && full.block_width == width && full.block_height != height)
    verdict.Add(layout, fmt::format("it is stored in strips, not in tiles: whoever shows a part reads {} "
                                    "pixels wide",
                                    width));
  if (is_large && levels.size() == 1)
    verdict.Add(layout, fmt::format("it has no overviews, and {} x {} pixels: far views read all of it",
                                    width, height));
  for (std::size_t i = 1; i < levels.size(); ++i) {
    const GDALRasterBand& finer = *levels[i - 1].band;
    GDALRasterBand& coarser = *levels[i].band;
    if (coarser.GetXSize() >= const_cast<GDALRasterBand&>(finer).GetXSize())
      verdict.Add(layout, levels[i].name + " is not smaller than the one before");
  }
}

bool HasOverviewsApart(GDALDataset& raster, const std::string& path) {
  char** files = raster.GetFileList();
  const bool has = CSLFindString(files, (path + ".ovr").c_str()) >= 0;
  CSLDestroy(files);
  return has;
}

// Directories from the full picture to the coarsest, then the pictures from the coarsest to the full one.
void JudgeOrder(const std::vector<Level>& levels, Severity layout, FileVerdict& verdict) {
  std::uint64_t directory_before = 0;
  std::optional<std::uint64_t> data_before;
  for (const Level& level : levels) {
    const auto directory = TiffNumber(*level.band, "IFD_OFFSET");
    if (!directory) continue;
    if (*directory < directory_before)
      verdict.Add(layout, fmt::format("the directory of {} stands before that of a finer one", level.name));
    directory_before = *directory;
    // Places that are not stored have none.
    const auto data = TiffNumber(*level.band, "BLOCK_OFFSET_0_0");
    if (data && *data < *directory)
      verdict.Add(layout, fmt::format("the pixels of {} stand before its directory", level.name));
    if (data && data_before && *data > *data_before)
      verdict.Add(layout, fmt::format("the pixels of {} stand behind those of a finer one", level.name));
    if (data) data_before = data;
  }
}

// Says which pixels are shown; null: nothing of its own does. Alpha is a band as the others.
GDALRasterBand* MaskOf(GDALRasterBand& band) {
  return band.GetMaskFlags() == GMF_PER_DATASET ? band.GetMaskBand() : nullptr;
}

class BlockWalk {
 public:
  BlockWalk(const fs::path& path, bool quick, FileVerdict& verdict, Progress& progress)
      : quick_(quick), verdict_(verdict), progress_(progress) {
    std::error_code gone;
    const std::uintmax_t bytes = fs::file_size(path, gone);
    bytes_ = gone ? 0 : bytes;
  }

  // False: cancelled.
  bool Look(GDALDataset& raster, const std::vector<Level>& levels) {
    double all = 0.0, done = 0.0;
    for (const Level& level : levels) all += Blocks(level);
    if (all > kMaxBlocks) {
      verdict_.Add(Severity::kNote, "it has too many blocks to read them all");
      return true;
    }
    CountedFindings findings;
    std::int64_t count = 0;
    for (std::size_t k = 0; k < levels.size(); ++k) {
      const Level& level = levels[k];
      GDALRasterBand* const mask = MaskOf(*level.band);
      const int columns = BlocksAcross(level.band->GetXSize(), level.block_width);
      const int rows = BlocksAcross(level.band->GetYSize(), level.block_height);
      for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
          if (progress_.IsCancelled()) return false;
          const std::string name = fmt::format("{} {},{}", level.name, x, y);
          const auto at = TiffNumber(*level.band, fmt::format("BLOCK_OFFSET_{}_{}", x, y));
          const auto size = TiffNumber(*level.band, fmt::format("BLOCK_SIZE_{}_{}", x, y));
          const bool is_outside = at && size && (*size > bytes_ || *at > bytes_ - *size);
          if (is_outside)
            findings.Add(Severity::kError, "blocks lie beyond the end of the file: it is cut off", name);
          const bool is_read = !quick_ || count++ % kQuickStep == 0;
          if (!is_outside && is_read && !CanBeRead(raster, k, level, x, y))
            findings.Add(Severity::kError, "blocks are damaged", name);
          if (is_read && mask != nullptr && !CanBeRead(*mask, level, x, y))
            findings.Add(Severity::kError, "blocks of the mask are damaged", name);
          progress_.Report(++done / all, "reading blocks");
        }
      }
    }
    findings.MoveTo(verdict_);
    return true;
  }

 private:
  static constexpr std::int64_t kQuickStep = 50;
  static constexpr double kMaxBlocks = 50e6;

  static int BlocksAcross(int size_px, int block_px) { return 1 + (size_px - 1) / std::max(block_px, 1); }
  static double Blocks(const Level& level) {
    return 1.0 * BlocksAcross(level.band->GetXSize(), level.block_width) *
           BlocksAcross(level.band->GetYSize(), level.block_height);
  }
  static bool CanBeRead(GDALDataset& raster, std::size_t k, const Level& level, int x, int y) {
    for (int number = 1; number <= raster.GetRasterCount(); ++number) {
      GDALRasterBand* band = raster.GetRasterBand(number);
      if (k > 0) band = band->GetOverview(static_cast<int>(k) - 1);
      if (band != nullptr && !CanBeRead(*band, level, x, y)) return false;
    }
    return true;
  }
  // Locking decodes it; an overview, band or mask of other blocks is read where these lie.
  static bool CanBeRead(GDALRasterBand& band, const Level& level, int x, int y) {
    int width = 0, height = 0;
    band.GetBlockSize(&width, &height);
    if (width != level.block_width || height != level.block_height) return true;
    GDALRasterBlock* block = band.GetLockedBlockRef(x, y);
    if (block == nullptr) return false;
    block->DropLock();
    return true;
  }

  const bool quick_;
  FileVerdict& verdict_;
  Progress& progress_;
  std::uint64_t bytes_ = 0;
};

}  // namespace

Result<FileVerdict> ValidateGeotiff(const fs::path& path, bool quick, Progress& progress) {
  RegisterGdalOnce();
  const QuietGdal quiet;
  FileVerdict verdict;
  verdict.file = path.filename().string();
  verdict.kind = "GeoTIFF";
  const char* const drivers[] = {"GTiff", nullptr};
  const std::unique_ptr<GDALDataset> raster(
      GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers, nullptr, nullptr));
  if (!raster || raster->GetRasterCount() < 1) {
    verdict.Add(Severity::kError, std::string("it cannot be opened: ") + CPLGetLastErrorMsg());
    return verdict;
  }
  JudgeGeoreference(*raster, verdict);
  std::vector<Level> levels = LevelsOf(*raster);
  const char* said = raster->GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE");
  const bool says_cog = said != nullptr && std::string(said) == "COG";
  const std::size_t before = verdict.findings.size();
  // One that calls itself cloud-optimised is believed by whoever reads parts of it.
  const Severity layout = says_cog ? Severity::kError : Severity::kWarning;
  JudgeTiling(levels, layout, verdict);
  if (HasOverviewsApart(*raster, path.string())) {
    verdict.Add(layout, "its overviews lie in another file (.ovr), which a copy leaves behind");
    levels.resize(1);  // places in that file are none in this one
  }
  JudgeOrder(levels, layout, verdict);
  if (verdict.findings.size() == before) {
    verdict.kind = "cloud-optimised GeoTIFF";
  } else if (!says_cog) {
    verdict.Add(Severity::kNote,
                "it is whole, but not cloud-optimised; \"gdal_translate -of COG\" makes it so");
  }
  if (!BlockWalk(path, quick, verdict, progress).Look(*raster, levels))
    return Error{ErrorCode::kCancelled, "Cancelled.", ""};
  return verdict;
}

}  // namespace skyquilt::storage
