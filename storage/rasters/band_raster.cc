#include "storage/rasters/band_raster.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/text/plain_text.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"
#include "core/geo/web_mercator.h"
#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

// The pixels of one direction whose middles lie on the raster, and what of the raster they cover.
struct Overlap {
  int first = 0, count = 0;
  double from = 0.0, to = 0.0;  // pixels of the raster
};
std::optional<Overlap> OverlapOf(double start, double step, int length, int raster_length) {
  const auto first = static_cast<int>(std::clamp(std::ceil(-start / step - 0.5), 0.0, double(length)));
  const auto end = static_cast<int>(
      std::clamp(std::ceil((raster_length - start) / step - 0.5), double(first), double(length)));
  if (end <= first) return std::nullopt;
  // What is as good as on the edge of a pixel is on it.
  const auto on_edge = [](double at) {
    constexpr double kOnEdge = 1e-3;
    return std::abs(at - std::round(at)) < kOnEdge ? std::round(at) : at;
  };
  const double from = std::max(0.0, on_edge(start + first * step));
  const double to = std::min<double>(raster_length, on_edge(start + end * step));
  return from < to ? std::optional(Overlap{first, end - first, from, to}) : std::nullopt;
}

// As our writer lays them out, with room to spare: of a block all is in memory before a pixel of it is.
bool HasUsualBlocks(GDALRasterBand& band) {
  constexpr int kMaxBlockPx = 2048;
  int width_px = 0, height_px = 0;
  band.GetBlockSize(&width_px, &height_px);
  const GDALDataType type = band.GetRasterDataType();
  if (width_px > kMaxBlockPx || height_px > kMaxBlockPx || (type != GDT_Float32 && type != GDT_UInt16))
    return false;
  for (int level = 0; level < band.GetOverviewCount(); ++level) {
    GDALRasterBand* const overview = band.GetOverview(level);
    if (overview == nullptr || overview->GetRasterDataType() != type) return false;
    overview->GetBlockSize(&width_px, &height_px);
    if (width_px > kMaxBlockPx || height_px > kMaxBlockPx) return false;
  }
  return true;
}

// Stored numbers to values, NaN where the file says that nothing is known.
void ToValues(GDALRasterBand& band, std::span<float> values) {
  int has_no_data = 0, has_scale = 0, has_offset = 0;
  const auto no_data = static_cast<float>(band.GetNoDataValue(&has_no_data));
  const double scale = band.GetScale(&has_scale), offset = band.GetOffset(&has_offset);
  const bool is_scaled = (has_scale != 0 && scale != 1.0) || (has_offset != 0 && offset != 0.0);
  for (float& value : values) {
    if (!std::isfinite(value) || (has_no_data != 0 && value == no_data)) {
      value = kUnknown;
    } else if (is_scaled) {
      value = static_cast<float>(value * scale + offset);
    }
  }
}

}  // namespace

const std::vector<std::string>& ColourBands() {
  static const std::vector<std::string> bands = {"red", "green", "blue"};
  return bands;
}

Result<std::vector<std::size_t>> PlacesOf(const indices::BandExpression& expression,
                                          const std::vector<std::string>& bands) {
  std::vector<std::size_t> places;
  for (const std::string& name : expression.bands()) {
    const auto found = std::find(bands.begin(), bands.end(), name);
    if (found == bands.end())
      return flight::Because(ErrorCode::kInvalidArgument,
                             {flight::RemarkCode::kIndexWithoutBand,
                              {{"band", name}, {"bands", fmt::format("{}", fmt::join(bands, ", "))}}});
    places.push_back(static_cast<std::size_t>(found - bands.begin()));
  }
  return places;
}

geo::Bounds2 BandRaster::BoundsInMerc() const {
  return {{west_m_, north_m_ - height_px_ * pixel_m_}, {west_m_ + width_px_ * pixel_m_, north_m_}};
}

Result<std::shared_ptr<BandRaster>> BandRaster::Open(const std::filesystem::path& path) {
  const QuietGdal quiet;
  std::shared_ptr<BandRaster> raster(new BandRaster(path));
  SKYQUILT_TRY_ASSIGN(OpenGeotiff opened, raster->files_.Take());
  GDALDataset& file = *opened;
  std::array<double, 6> transform{};
  const bool is_placed = file.GetGeoTransform(transform.data()) == CE_None && transform[1] > 0.0 &&
                         std::abs(transform[1] + transform[5]) < 1e-9 * transform[1] && transform[2] == 0.0 &&
                         transform[4] == 0.0;
  if (!is_placed) return raster->files_.Damaged("it does not lie on the grid of the web map");
  // From the west of the antimeridian on, as the bounds of a map across it are.
  const bool is_beyond = transform[0] < -geo::kMercHalfWidthM - transform[1];
  raster->west_m_ = transform[0] + (is_beyond ? 2.0 * geo::kMercHalfWidthM : 0.0);
  raster->north_m_ = transform[3];
  raster->pixel_m_ = transform[1];
  raster->width_px_ = file.GetRasterXSize();
  raster->height_px_ = file.GetRasterYSize();
  for (int place = 1; place <= std::min(file.GetRasterCount(), kMaxBands); ++place) {
    GDALRasterBand& band = *file.GetRasterBand(place);
    if (!HasUsualBlocks(band)) return raster->files_.Damaged("it is not laid out as a map's is");
    if (band.GetColorInterpretation() == GCI_AlphaBand) continue;
    const std::string name = LowerCase(band.GetDescription());
    raster->bands_.push_back(name.empty() ? fmt::format("b{}", place) : name);
    raster->places_.push_back(place);
  }
  if (raster->bands_.empty()) return raster->files_.Damaged("it has no bands");
  raster->files_.Give(std::move(opened));
  return raster;
}

Result<std::vector<std::vector<float>>> BandRaster::Read(const MercGrid& grid,
                                                         std::span<const std::size_t> bands) {
  if (grid.width_px < 1 || grid.height_px < 1 || grid.width_px > kMaxSidePx || grid.height_px > kMaxSidePx)
    return Error{ErrorCode::kInvalidArgument, "More pixels are asked for than are read at once.", ""};
  const auto pixels = static_cast<std::size_t>(grid.width_px) * static_cast<std::size_t>(grid.height_px);
  std::vector<std::vector<float>> planes(bands.size(), std::vector<float>(pixels, kUnknown));
  // A raster across the antimeridian goes on beyond the web map's square, where tiles lie at its other end.
  const double off_m = west_m_ + 0.5 * pixel_m_ * width_px_ - grid.west_m -
                       0.5 * grid.pixel_width_m * static_cast<double>(grid.width_px);
  constexpr double kWorldM = 2.0 * geo::kMercHalfWidthM;
  const double west_m = grid.west_m + kWorldM * std::round(off_m / kWorldM);
  const std::optional<Overlap> x =
      OverlapOf((west_m - west_m_) / pixel_m_, grid.pixel_width_m / pixel_m_, grid.width_px, width_px_);
  const std::optional<Overlap> y = OverlapOf((north_m_ - grid.north_m) / pixel_m_,
                                             grid.pixel_height_m / pixel_m_, grid.height_px, height_px_);
  if (!x || !y) return planes;
  const QuietGdal quiet;
  SKYQUILT_TRY_ASSIGN(OpenGeotiff file, files_.Take());
  GDALRasterIOExtraArg how;
  INIT_RASTERIO_EXTRA_ARG(how);
  const bool is_coarser = x->to - x->from > x->count || y->to - y->from > y->count;
  how.eResampleAlg = is_coarser ? GRIORA_Average : GRIORA_NearestNeighbour;
  how.bFloatingPointWindowValidity = TRUE;
  how.dfXOff = x->from;
  how.dfYOff = y->from;
  how.dfXSize = x->to - x->from;
  how.dfYSize = y->to - y->from;
  const auto left = static_cast<int>(std::floor(x->from)), top = static_cast<int>(std::floor(y->from));
  const auto width = static_cast<int>(std::ceil(x->to)) - left,
             height = static_cast<int>(std::ceil(y->to)) - top;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    GDALRasterBand& band = *file->GetRasterBand(places_.at(bands[i]));
    float* const first = planes[i].data() +
                         static_cast<std::size_t>(y->first) * static_cast<std::size_t>(grid.width_px) +
                         static_cast<std::size_t>(x->first);
    const CPLErr read =
        band.RasterIO(GF_Read, left, top, width, height, first, x->count, y->count, GDT_Float32,
                      sizeof(float), GSpacing{sizeof(float)} * grid.width_px, &how);
    if (read != CE_None) return files_.Damaged("some of its pixels are damaged");
    for (int row = 0; row < y->count; ++row) {
      ToValues(band, {first + static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.width_px),
                      static_cast<std::size_t>(x->count)});
    }
  }
  files_.Give(std::move(file));
  return planes;
}

}  // namespace skyquilt::storage
