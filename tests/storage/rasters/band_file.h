// A bands.tif as maps have it beside them: a tiled GeoTIFF in Web Mercator with overviews, written by GDAL.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace skyquilt::test {

struct BandFile {
  double west_m = 0.0, north_m = 0.0, pixel_m = 1.0;  // merc
  int width_px = 0, height_px = 0;
  std::vector<std::string> bands;
  // Of a band's pixel; NaN: nothing known.
  std::function<float(int band, int column, int row)> value;
  bool is_whole_numbers = false;  // as thousandths from a tenth below zero on, 0 where nothing is known
  bool has_overviews = true;
  int block_px = 256;
};
void WriteBandFile(const std::filesystem::path& path, const BandFile& file);

}  // namespace skyquilt::test
