// What GDAL reads in a file that was written: OpenByGdal, TransformOf, PixelAt, PixelsOf. A file or a pixel
// that it cannot read fails the test and ends it.
#pragma once

#include <gdal_priv.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace skyquilt::test {

// `flags`: GDAL_OF_VECTOR for files of lines and outlines.
inline std::unique_ptr<GDALDataset> OpenByGdal(const std::filesystem::path& path,
                                               unsigned flags = GDAL_OF_RASTER) {
  std::unique_ptr<GDALDataset> opened(GDALDataset::Open(path.c_str(), flags | GDAL_OF_VERBOSE_ERROR));
  if (opened == nullptr) throw std::runtime_error("GDAL cannot open " + path.string());
  return opened;
}

// As GDAL numbers them: 0 and 3 are the corner in the north-west, 1 and 5 what a pixel measures.
inline std::array<double, 6> TransformOf(GDALDataset& raster) {
  std::array<double, 6> transform{};
  if (raster.GetGeoTransform(transform.data()) != CE_None) throw std::runtime_error("it lies nowhere");
  return transform;
}

// So many pixels from one on, row by row.
template <typename Value = std::uint8_t>
std::vector<Value> PixelsOf(GDALRasterBand& band, int left, int top, int width, int height) {
  constexpr GDALDataType kType = std::is_same_v<Value, std::uint8_t> ? GDT_Byte
                                 : std::is_same_v<Value, float>      ? GDT_Float32
                                                                     : GDT_Float64;
  std::vector<Value> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  if (band.RasterIO(GF_Read, left, top, width, height, pixels.data(), width, height, kType, 0, 0, nullptr) !=
      CE_None)
    throw std::runtime_error("GDAL cannot read a band");
  return pixels;
}
template <typename Value = std::uint8_t>
std::vector<Value> PixelsOf(GDALRasterBand& band) {
  return PixelsOf<Value>(band, 0, 0, band.GetXSize(), band.GetYSize());
}
template <typename Value = std::uint8_t>
Value PixelAt(GDALRasterBand& band, int column, int row) {
  return PixelsOf<Value>(band, column, row, 1, 1)[0];
}

}  // namespace skyquilt::test
