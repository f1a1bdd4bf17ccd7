#include "storage/rasters/geotiff_dem.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <fmt/format.h>
#include <gdal_frmts.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <mutex>
#include <string_view>
#include <utility>

#include "core/base/text/plain_text.h"
#include "core/flight/remarks/because.h"
#include "core/geo/geoid.h"

namespace skyquilt::storage {
namespace {

constexpr std::int64_t kCacheBytes = std::int64_t{64} << 20;
// GDAL reads a raster by its blocks, whole; four of them lie around a point.
constexpr std::int64_t kMaxBlockBytes = kCacheBytes / 4;
constexpr int kMaxBands = 16;

// Only the GeoTIFF driver, without reading sibling files.
void RegisterGeotiffOnce() {
  static std::once_flag once;
  std::call_once(once, [] {
    CPLSetConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR");
    CPLSetConfigOption("GDAL_PAM_ENABLED", "NO");
    CPLSetConfigOption("GTIFF_VIRTUAL_MEM_IO", "NO");
    CPLSetConfigOption("GDAL_NUM_THREADS", "1");
    OSRSetPROJEnableNetwork(0);
    GDALSetCacheMax64(kCacheBytes);
    GDALRegister_GTiff();
  });
}

// Nothing where it is none that heights are given in.
std::optional<double> MetresPerUnit(std::string_view unit) {
  constexpr double kFootM = 0.3048, kSurveyFootM = 1200.0 / 3937.0;
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"", 1.0},
      {"m", 1.0},
      {"metre", 1.0},
      {"metres", 1.0},
      {"meter", 1.0},
      {"meters", 1.0},
      {"ft", kFootM},
      {"foot", kFootM},
      {"feet", kFootM},
      {"international foot", kFootM},
      {"us survey foot", kSurveyFootM},
      {"us survey feet", kSurveyFootM},
      {"us-ft", kSurveyFootM},
      {"us_ft", kSurveyFootM},
      {"ftus", kSurveyFootM},
      {"foot_us", kSurveyFootM},
  };
  const std::string lower = LowerCase(Trim(unit));
  for (const auto& [name, metres] : kUnits) {
    if (name == lower) return metres;
  }
  return std::nullopt;
}

// Of the vertical axis, where the system has one; else nothing.
std::optional<double> MetresPerUnitUpwards(const OGRSpatialReference& system) {
  if (system.GetAxesCount() != 3) return std::nullopt;
  OGRAxisOrientation orientation = OAO_Other;
  double metres = 0.0;
  const bool is_known = system.GetAxis(nullptr, 2, &orientation, &metres) != nullptr && metres > 0.0;
  return is_known ? std::optional(metres) : std::nullopt;
}

// Of the ground, in metres above whatever zero: others mark holes of which no tag tells (-9999, -32768, the
// largest float).
bool IsHeightOfGround(double height_m) {
  constexpr double kLowestM = -600.0, kHighestM = 9500.0;
  return height_m > kLowestM && height_m < kHighestM;
}

// A mark of holes such as -9999.9 stands in the file's cells as the nearest float.
double AsStored(double hole, GDALDataType type) {
  const bool is_float = type == GDT_Float32 && std::abs(hole) <= std::numeric_limits<float>::max();
  return is_float ? static_cast<float>(hole) : hole;
}

struct DropTransform {
  void operator()(OGRCoordinateTransformation* transform) const {
    OGRCoordinateTransformation::DestroyCT(transform);
  }
};

}  // namespace

struct GeotiffDem::Raster {
  bool is_ellipsoidal = false;  // a three-dimensional system without a vertical one of its own
  std::unique_ptr<GDALDataset> dataset;
  std::unique_ptr<OGRCoordinateTransformation, DropTransform> model_from_wgs84;
  std::array<double, 6> pixel_from_model{};
  std::optional<double> middle_deg;  // its longitude, where it counts in degrees
  std::optional<double> hole;
  double scale_m = 1.0;
  double offset_m = 0.0;
  std::string unknown_unit;
};

GeotiffDem::GeotiffDem(std::unique_ptr<Raster> raster) : raster_(std::move(raster)) {}
GeotiffDem::~GeotiffDem() = default;

Result<std::unique_ptr<GeotiffDem>> GeotiffDem::Open(const std::filesystem::path& path) {
  RegisterGeotiffOnce();
  std::error_code missing;
  if (!std::filesystem::is_regular_file(path, missing)) {
    return Error{ErrorCode::kNotFound,
                 "The elevation model " + path.string() + " does not exist. Check its path.", ""};
  }
  const auto refuse = [&](const std::string& why) {
    return flight::Because(ErrorCode::kUnsupportedFormat, {flight::RemarkCode::kElevationsRefused,
                                                           {{"model", path.string()}, {"why_words", why}}});
  };
  auto raster = std::make_unique<Raster>();
  const char* const drivers[] = {"GTiff", nullptr};
  // Errors are reported by our own messages, not by GDAL's on stderr.
  CPLErrorHandlerPusher quiet(CPLQuietErrorHandler);
  raster->dataset.reset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers));
  if (!raster->dataset || raster->dataset->GetRasterCount() < 1) return refuse("cannot be read");
  if (raster->dataset->GetRasterCount() > kMaxBands)
    return refuse(fmt::format("has more than {} bands", kMaxBands));
  int block_width = 0;
  int block_height = 0;
  raster->dataset->GetRasterBand(1)->GetBlockSize(&block_width, &block_height);
  const std::int64_t block_bytes =
      std::int64_t{block_width} * block_height *
      GDALGetDataTypeSizeBytes(raster->dataset->GetRasterBand(1)->GetRasterDataType()) *
      raster->dataset->GetRasterCount();
  if (block_bytes > kMaxBlockBytes) {
    return refuse(
        fmt::format("is stored in blocks of {} MiB, of which at most {} are read at once (gdal_translate "
                    "-co TILED=YES -co COMPRESS=DEFLATE stores it in small ones)",
                    block_bytes >> 20, kMaxBlockBytes >> 20));
  }
  std::array<double, 6> model_from_pixel{};
  const OGRSpatialReference* system = raster->dataset->GetSpatialRef();
  if (system == nullptr || raster->dataset->GetGeoTransform(model_from_pixel.data()) != CE_None ||
      !GDALInvGeoTransform(model_from_pixel.data(), raster->pixel_from_model.data())) {
    return refuse("does not say where on Earth it lies");
  }
  raster->is_ellipsoidal = !system->IsCompound() && system->GetAxesCount() == 3;
  OGRSpatialReference horizontal(*system);
  if (horizontal.IsCompound()) horizontal.StripVertical();
  horizontal.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  OGRSpatialReference wgs84;
  wgs84.importFromEPSG(4326);
  wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  raster->model_from_wgs84.reset(OGRCreateCoordinateTransformation(&wgs84, &horizontal));
  if (!raster->model_from_wgs84) return refuse("lies in an unknown coordinate system");
  constexpr double kRadInDegree = 0.017453292519943295;
  if (horizontal.IsGeographic() && std::abs(horizontal.GetAngularUnits() / kRadInDegree - 1.0) < 1e-6) {
    raster->middle_deg = model_from_pixel[0] + 0.5 * raster->dataset->GetRasterXSize() * model_from_pixel[1] +
                         0.5 * raster->dataset->GetRasterYSize() * model_from_pixel[2];
  }
  GDALRasterBand* band = raster->dataset->GetRasterBand(1);
  int has_hole = 0;
  const double hole = band->GetNoDataValue(&has_hole);
  if (has_hole != 0) raster->hole = AsStored(hole, band->GetRasterDataType());
  const std::optional<double> upwards_m = MetresPerUnitUpwards(*system);
  const std::optional<double> stated_m = MetresPerUnit(band->GetUnitType());
  if (!upwards_m && !stated_m) raster->unknown_unit = band->GetUnitType();
  // Metres are also written by tools that know no other unit: of two that differ, the other one is meant.
  const double unit_m = upwards_m && *upwards_m != 1.0 ? *upwards_m : stated_m.value_or(1.0);
  raster->scale_m = unit_m * band->GetScale();
  raster->offset_m = unit_m * band->GetOffset();
  return std::unique_ptr<GeotiffDem>(new GeotiffDem(std::move(raster)));
}

const std::string& GeotiffDem::unknown_unit() const { return raster_->unknown_unit; }

std::optional<double> GeotiffDem::GroundHeightM(const geo::LatLon& position) const {
  double x = position.lon_deg;
  double y = position.lat_deg;
  if (!raster_->model_from_wgs84->Transform(1, &x, &y)) return std::nullopt;
  // Models go on across the antimeridian, and some count from 0 to 360 degrees.
  if (raster_->middle_deg && std::abs(x - *raster_->middle_deg) > 180.0)
    x -= 360.0 * std::round((x - *raster_->middle_deg) / 360.0);
  const std::array<double, 6>& t = raster_->pixel_from_model;
  // GDAL counts from the outer corner of the first pixel, the heights stand at the middles.
  const double column = t[0] + t[1] * x + t[2] * y - 0.5;
  const double row = t[3] + t[4] * x + t[5] * y - 0.5;
  const int width = raster_->dataset->GetRasterXSize();
  const int height = raster_->dataset->GetRasterYSize();
  if (!(column >= -0.5 && row >= -0.5 && column <= width - 0.5 && row <= height - 0.5)) return std::nullopt;
  double sum = 0.0;
  double weight = 0.0;
  for (int corner = 0; corner < 4; ++corner) {
    const int c = std::clamp(static_cast<int>(std::floor(column)) + corner % 2, 0, width - 1);
    const int r = std::clamp(static_cast<int>(std::floor(row)) + corner / 2, 0, height - 1);
    const double across = column - std::floor(column);
    const double down = row - std::floor(row);
    const double w = (corner % 2 == 1 ? across : 1.0 - across) * (corner / 2 == 1 ? down : 1.0 - down);
    double value = 0.0;
    if (raster_->dataset->GetRasterBand(1)->RasterIO(GF_Read, c, r, 1, 1, &value, 1, 1, GDT_Float64, 0, 0) !=
        CE_None) {
      return std::nullopt;
    }
    // A hole beside solid ground: what is left of the four cells says it.
    const bool is_hole = raster_->hole && value == *raster_->hole;
    if (is_hole || !IsHeightOfGround(raster_->scale_m * value + raster_->offset_m)) continue;
    sum += w * value;
    weight += w;
  }
  if (weight < 0.25) return std::nullopt;
  const double height_m = raster_->scale_m * sum / weight + raster_->offset_m;
  return raster_->is_ellipsoidal ? height_m - geo::GeoidHeightM(position).value_or(0.0) : height_m;
}

}  // namespace skyquilt::storage
