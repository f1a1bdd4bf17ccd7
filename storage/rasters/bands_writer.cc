#include "storage/rasters/bands_writer.h"

#include <fmt/core.h>
#include <gdal_priv.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "core/base/try.h"
#include "core/image/decoded_image.h"
#include "storage/files/publish_file.h"
#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kMessage = "writing bands.tif";

void DescribeBand(const bands::RasterBand& from, GDALRasterBand& band) {
  band.SetDescription(from.name.c_str());
  band.SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
  if (from.wavelength_nm > 0.0) {
    band.SetMetadataItem("WAVELENGTH", fmt::format("{:g}", from.wavelength_nm).c_str());
    band.SetMetadataItem("WAVELENGTH_UNITS", "nm");
  }
  if (from.width_nm > 0.0) band.SetMetadataItem("FWHM", fmt::format("{:g}", from.width_nm).c_str());
  band.SetMetadataItem("CALIBRATION", from.calibration.c_str());
  band.SetMetadataItem("METHOD", from.method.c_str());
}

// The smallest box around all pixels with a value, in pixels of the block.
image::PixelBox Covered(const std::vector<std::vector<float>>& values, int side) {
  image::PixelBox box{side, side, 0, 0};
  for (const std::vector<float>& band : values) {
    for (int y = 0; y < side; ++y) {
      const float* row = band.data() + static_cast<std::ptrdiff_t>(y) * side;
      for (int x = 0; x < side; ++x) {
        if (std::isnan(row[x])) continue;
        box.left = std::min(box.left, x), box.right = std::max(box.right, x + 1);
        box.top = std::min(box.top, y), box.bottom = std::max(box.bottom, y + 1);
      }
    }
  }
  return box;
}

// Fourteen binary digits, as many as the sensors have and two more: the rest is noise that packs badly.
float WithoutNoise(float value) {
  constexpr std::uint32_t kDropped = 0x3FF, kHalf = 0x200, kExponent = 0x7F800000;
  auto bits = std::bit_cast<std::uint32_t>(value);
  if ((bits & kExponent) == kExponent) return value;  // nothing known
  bits = (bits + kHalf) & ~kDropped;
  return std::bit_cast<float>(bits);
}

}  // namespace

struct BandsWriter::Work {
  std::filesystem::path path;
  int threads;
  Progress& progress;
  TemporaryFile raw, made;
  std::unique_ptr<GDALDataset> dataset;
  int block_px = 0;
  image::PixelBox covered;
};

BandsWriter::BandsWriter(std::filesystem::path path, int threads, Progress& progress)
    : work_(new Work{path, threads, progress, {path, ".raw.tmp"}, {path, ".tmp"}, nullptr, 0, {}}) {}
BandsWriter::~BandsWriter() = default;

Result<void> BandsWriter::Begin(const bands::BandRaster& raster) {
  const MercGrid grid{raster.west_in_merc_m,  raster.north_in_merc_m, raster.pixel_in_merc_m,
                      raster.pixel_in_merc_m, raster.width_px,        raster.height_px};
  SKYQUILT_TRY_ASSIGN(
      work_->dataset,
      CreateMercFloats(work_->raw.path(), grid, static_cast<int>(raster.bands.size()), work_->progress));
  for (std::size_t i = 0; i < raster.bands.size(); ++i)
    DescribeBand(raster.bands[i], *work_->dataset->GetRasterBand(static_cast<int>(i) + 1));
  work_->block_px = raster.block_px;
  return {};
}

Result<void> BandsWriter::Put(int left_px, int top_px, const std::vector<std::vector<float>>& values) {
  const int side = work_->block_px;
  const image::PixelBox box = Covered(values, side);
  if (box.IsEmpty()) return {};
  work_->covered =
      work_->covered.With({left_px + box.left, top_px + box.top, left_px + box.right, top_px + box.bottom});
  std::vector<float> kept;
  for (std::size_t i = 0; i < values.size(); ++i) {
    kept.resize(values[i].size());
    std::transform(values[i].begin(), values[i].end(), kept.begin(), WithoutNoise);
    if (work_->dataset->GetRasterBand(static_cast<int>(i) + 1)
            ->RasterIO(GF_Write, left_px, top_px, side, side, kept.data(), side, side, GDT_Float32, 0, 0,
                       nullptr) != CE_None)
      return LastGdalError(work_->progress);
  }
  return {};
}

Result<void> BandsWriter::Publish() {
  if (!work_->dataset || !IsClosedWell(std::move(work_->dataset))) return LastGdalError(work_->progress);
  if (work_->covered.IsEmpty()) return {};
  const std::unique_ptr<GDALDataset> source(
      GDALDataset::Open(work_->raw.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!source) return LastGdalError(work_->progress);
  const image::PixelBox& box = work_->covered;
  CPLStringList words;
  AddGdalWords(words, {"-of", "COG", "-srcwin", std::to_string(box.left), std::to_string(box.top),
                       std::to_string(box.right - box.left), std::to_string(box.bottom - box.top)});
  AddGdalWords(words, {"-co", "COMPRESS=DEFLATE", "-co", "LEVEL=1", "-co", "PREDICTOR=YES"});
  AddGdalWords(words, {"-co", "OVERVIEW_RESAMPLING=AVERAGE", "-co", "BIGTIFF=IF_SAFER", "-co",
                       GdalThreads(work_->threads)});
  GdalStep step{work_->progress, kMessage};
  if (!TranslateRaster(*source, work_->made.c_str(), words, &step)) return LastGdalError(work_->progress);
  return PublishFile(work_->made.path(), work_->path);
}

}  // namespace skyquilt::storage
