#include "storage/exports/heights/contours.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <fmt/format.h>
#include <gdal_alg.h>
#include <gdal_priv.h>
#include <gdal_utils.h>
#include <ogr_spatialref.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/try.h"
#include "storage/files/publish_file.h"
#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {
namespace {

using Dataset = std::unique_ptr<GDALDataset>;

constexpr const char* kWriting = "writing contours";
constexpr double kMinIntervalM = 0.1;
constexpr double kMaxCells = 4e6;         // of the averaged raster, which is held whole
constexpr double kShortestInCells = 8.0;  // what is shorter goes round a bump of noise
// A GeoPackage says when it was last changed, which nothing but the clock knows: the same bytes each time.
constexpr const char* kNoDate = "2000-01-01T00:00:00.000Z";

struct ContourFile {
  const char* driver;
  const char* ending;
  std::vector<const char*> options;
};

Dataset CreateIn(const char* driver_name, int columns, int rows, int bands) {
  GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName(driver_name);
  if (driver == nullptr) return nullptr;
  return Dataset(driver->Create("", columns, rows, bands, bands > 0 ? GDT_Float32 : GDT_Unknown, nullptr));
}

// In memory, averaged to cells of about that size.
Dataset Averaged(GDALDataset& heights, double smooth_m) {
  std::array<double, 6> transform{};
  if (heights.GetGeoTransform(transform.data()) != CE_None) return nullptr;
  const double whole = static_cast<double>(heights.GetRasterXSize()) * heights.GetRasterYSize();
  const double shrink = std::max({1.0, smooth_m / transform[1], std::sqrt(whole / kMaxCells)});
  const auto shrunk = [&](int cells) { return std::max(1, static_cast<int>(std::lround(cells / shrink))); };
  const int columns = shrunk(heights.GetRasterXSize()), rows = shrunk(heights.GetRasterYSize());
  Dataset averaged = CreateIn("MEM", columns, rows, 1);
  if (!averaged) return nullptr;
  std::vector<float> values(static_cast<std::size_t>(columns) * rows);
  GDALRasterIOExtraArg how;
  INIT_RASTERIO_EXTRA_ARG(how);
  how.eResampleAlg = GRIORA_Average;
  if (heights.GetRasterBand(1)->RasterIO(GF_Read, 0, 0, heights.GetRasterXSize(), heights.GetRasterYSize(),
                                         values.data(), columns, rows, GDT_Float32, 0, 0, &how) != CE_None)
    return nullptr;
  transform[1] *= static_cast<double>(heights.GetRasterXSize()) / columns;
  transform[5] *= static_cast<double>(heights.GetRasterYSize()) / rows;
  GDALRasterBand& band = *averaged->GetRasterBand(1);
  if (averaged->SetGeoTransform(transform.data()) != CE_None ||
      averaged->SetSpatialRef(heights.GetSpatialRef()) != CE_None ||
      band.SetNoDataValue(std::numeric_limits<double>::quiet_NaN()) != CE_None ||
      band.RasterIO(GF_Write, 0, 0, columns, rows, values.data(), columns, rows, GDT_Float32, 0, 0,
                    nullptr) != CE_None)
    return nullptr;
  return averaged;
}

// Nothing where no cell has a height.
std::optional<std::array<double, 2>> RangeOf(GDALDataset& heights) {
  std::array<double, 2> range{};
  const bool is_known = heights.GetRasterBand(1)->ComputeRasterMinMax(FALSE, range.data()) == CE_None;
  return is_known ? std::optional(range) : std::nullopt;
}

Result<Dataset> LinesOf(GDALDataset& heights, double interval_m, double shortest_m, Progress& progress) {
  Dataset lines = CreateIn("Memory", 0, 0, 0);
  const OGRSpatialReference* system = heights.GetSpatialRef();
  OGRLayer* layer =
      lines ? lines->CreateLayer("contours", const_cast<OGRSpatialReference*>(system), wkbLineString25D)
            : nullptr;
  OGRFieldDefn field("height_m", OFTReal);
  if (layer == nullptr || layer->CreateField(&field) != OGRERR_NONE) return LastGdalError(progress);
  CPLStringList how;
  how.AddNameValue("LEVEL_INTERVAL", fmt::format("{}", interval_m).c_str());
  how.AddNameValue("ELEV_FIELD", "0");
  how.AddNameValue("NODATA", "nan");
  GdalStep step{progress, kWriting, 0.0, 0.7};
  if (GDALContourGenerateEx(heights.GetRasterBand(1), layer, how.List(), ForwardGdalProgress, &step) !=
      CE_None)
    return LastGdalError(progress);
  std::vector<GIntBig> short_ones;
  for (auto& feature : *layer) {
    const auto* line = feature->GetGeometryRef()->toLineString();
    if (line->get_Length() < shortest_m) short_ones.push_back(feature->GetFID());
  }
  for (const GIntBig id : short_ones) {
    if (layer->DeleteFeature(id) != OGRERR_NONE) return LastGdalError(progress);
  }
  return lines;
}

Result<void> WriteLines(GDALDataset& lines, const ContourFile& file, const TemporaryFile& made,
                        Progress& progress) {
  std::error_code gone;  // what cannot be removed cannot be written either, which is said
  std::filesystem::remove(made.path(), gone);
  CPLStringList words;
  AddGdalWords(words, {"-f", file.driver});
  for (const char* word : file.options) words.AddString(word);
  const std::unique_ptr<GDALVectorTranslateOptions, void (*)(GDALVectorTranslateOptions*)> translate(
      GDALVectorTranslateOptionsNew(words.List(), nullptr), GDALVectorTranslateOptionsFree);
  if (!translate) return LastGdalError(progress);
  GDALDatasetH from = GDALDataset::ToHandle(&lines);
  CPLErrorReset();
  CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", kNoDate);
  Dataset written(GDALDataset::FromHandle(
      GDALVectorTranslate(made.c_str(), nullptr, 1, &from, translate.get(), nullptr)));
  const bool is_written = written && IsClosedWell(std::move(written));
  CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", nullptr);
  if (!is_written) return LastGdalError(progress);
  return {};
}

}  // namespace

double ContourIntervalM(double lowest_m, double highest_m) {
  constexpr std::array kSteps = {1.0, 2.0, 5.0};
  for (double decade = kMinIntervalM;; decade *= 10.0) {
    for (const double step : kSteps) {
      if (!(highest_m - lowest_m > kMaxContours * decade * step)) return decade * step;
    }
  }
}

Result<double> WriteContours(const std::filesystem::path& heights, double smooth_m, Progress& progress) {
  const std::vector<ContourFile> files = {
      {"GPKG", ".gpkg", {"-nln", "contours"}},
      {"GeoJSON", ".geojson", {"-t_srs", "EPSG:4326", "-lco", "RFC7946=YES"}},
      {"DXF", ".dxf", {"-select", ""}},
  };
  const std::filesystem::path folder = heights.parent_path();
  const auto path_of = [&](const ContourFile& file) {
    return folder / fmt::format("contours{}", file.ending);
  };
  std::error_code gone;  // what cannot be removed cannot be written either, which is said
  for (const ContourFile& file : files) std::filesystem::remove(path_of(file), gone);  // of other heights
  RegisterGdalOnce();
  // Else it says of DXF that it knows no fields, and of unknown ground that it has no range.
  const QuietGdal quiet;
  const Dataset source(GDALDataset::Open(heights.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!source) return LastGdalError(progress);
  const Dataset averaged = Averaged(*source, smooth_m);
  if (!averaged) return LastGdalError(progress);
  const auto range = RangeOf(*averaged).value_or(std::array<double, 2>{});
  const double interval_m = ContourIntervalM(range[0], range[1]);
  SKYQUILT_TRY_ASSIGN(const Dataset lines,
                      LinesOf(*averaged, interval_m, kShortestInCells * smooth_m, progress));
  std::vector<std::unique_ptr<TemporaryFile>> made;
  for (const ContourFile& file : files) {
    // GDAL knows formats by their endings.
    made.push_back(std::make_unique<TemporaryFile>(folder / "contours.tmp", file.ending));
    SKYQUILT_TRY(WriteLines(*lines, file, *made.back(), progress));
  }
  // Once all are there: beside older ones of other formats they would pass for the same lines.
  for (std::size_t i = 0; i < files.size(); ++i)
    SKYQUILT_TRY(PublishFile(made[i]->path(), path_of(files[i])));
  return interval_m;
}

}  // namespace skyquilt::storage
