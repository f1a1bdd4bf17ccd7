// WriteHeights: a GeoTIFF of heights in a UTM zone, square, its north-west corner at kHeightsWestM and
// kHeightsNorthM. For tests of what is made of dsm.tif and dtm.tif. Places in metres of the zone.
#pragma once

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <array>
#include <filesystem>
#include <limits>
#include <memory>
#include <vector>

#include "storage/rasters/gdal_steps.h"

namespace skyquilt::storage {

inline constexpr int kHeightsEpsg = 32632;
inline constexpr double kHeightsWestM = 380'000.0, kHeightsNorthM = 5'200'000.0, kHeightsCellM = 0.1;

// height_at: by the middle of a cell, east and north; not a number where nothing is known.
inline void WriteHeights(const std::filesystem::path& path, int side, double (*height_at)(double, double)) {
  RegisterGdalOnce();
  const std::unique_ptr<GDALDataset> raster(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      path.c_str(), side, side, 1, GDT_Float32, nullptr));
  ASSERT_NE(raster, nullptr);
  OGRSpatialReference utm;
  utm.importFromEPSG(kHeightsEpsg);
  std::array<double, 6> transform = {kHeightsWestM, kHeightsCellM, 0.0, kHeightsNorthM, 0.0, -kHeightsCellM};
  raster->SetSpatialRef(&utm);
  raster->SetGeoTransform(transform.data());
  raster->GetRasterBand(1)->SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
  std::vector<float> values;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      values.push_back(static_cast<float>(height_at(kHeightsWestM + (column + 0.5) * kHeightsCellM,
                                                    kHeightsNorthM - (row + 0.5) * kHeightsCellM)));
    }
  }
  ASSERT_EQ(raster->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, side, side, values.data(), side, side,
                                               GDT_Float32, 0, 0, nullptr),
            CE_None);
}

}  // namespace skyquilt::storage
