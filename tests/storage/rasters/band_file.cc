#include "tests/storage/rasters/band_file.h"

#include <cpl_string.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

namespace skyquilt::test {
namespace {

constexpr double kScale = 0.001, kOffset = -0.1;

void Require(bool went_well) {
  if (!went_well) throw std::runtime_error("the test's bands cannot be written");
}

}  // namespace

void WriteBandFile(const std::filesystem::path& path, const BandFile& file) {
  GDALAllRegister();
  CPLStringList options;
  options.SetNameValue("TILED", "YES");
  options.SetNameValue("COMPRESS", "DEFLATE");
  for (const char* side : {"BLOCKXSIZE", "BLOCKYSIZE"})
    options.SetNameValue(side, std::to_string(file.block_px).c_str());
  const std::unique_ptr<GDALDataset> written(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      path.c_str(), file.width_px, file.height_px, static_cast<int>(file.bands.size()),
      file.is_whole_numbers ? GDT_UInt16 : GDT_Float32, options.List()));
  Require(written != nullptr);
  double transform[6] = {file.west_m, file.pixel_m, 0.0, file.north_m, 0.0, -file.pixel_m};
  written->SetGeoTransform(transform);
  OGRSpatialReference merc;
  merc.importFromEPSG(3857);
  written->SetSpatialRef(&merc);
  std::vector<float> row(static_cast<std::size_t>(file.width_px));
  for (int b = 0; b < static_cast<int>(file.bands.size()); ++b) {
    GDALRasterBand& band = *written->GetRasterBand(b + 1);
    band.SetDescription(file.bands[static_cast<std::size_t>(b)].c_str());
    if (file.is_whole_numbers) {
      band.SetScale(kScale);
      band.SetOffset(kOffset);
    }
    band.SetNoDataValue(file.is_whole_numbers ? 0.0 : std::numeric_limits<double>::quiet_NaN());
    for (int r = 0; r < file.height_px; ++r) {
      for (int c = 0; c < file.width_px; ++c) {
        float& cell = row[static_cast<std::size_t>(c)];
        cell = file.value(b, c, r);
        if (file.is_whole_numbers)
          cell = std::isnan(cell) ? 0.0f : static_cast<float>(std::lround((cell - kOffset) / kScale));
      }
      Require(band.RasterIO(GF_Write, 0, r, file.width_px, 1, row.data(), file.width_px, 1, GDT_Float32, 0, 0,
                            nullptr) == CE_None);
    }
  }
  int levels[] = {2, 4, 8};
  if (file.has_overviews)
    Require(written->BuildOverviews("AVERAGE", 3, levels, 0, nullptr, nullptr, nullptr) == CE_None);
}

}  // namespace skyquilt::test
