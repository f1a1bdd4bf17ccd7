// MapPicture: a finished map as one small picture whose pixels have a known size on the ground, north up.
// Temporary files lie in `work_folder`. Blocking. Errors: those of storage::ExportMap and WriteThumbnail,
// kCorrupt.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"

namespace skyquilt::server {

struct MapPicture {
  std::vector<std::uint8_t> webp;  // transparent where the map is empty
  int width_px = 0;
  int height_px = 0;
  double pixel_m = 0.0;
};

Result<MapPicture> MakeMapPicture(const std::filesystem::path& map, int longer_side_px,
                                  const std::filesystem::path& work_folder, Progress& progress);

// 1, 2 or 5 times a power of ten: the longest scale bar that is no longer than this.
double ScaleBarM(double most_m);

}  // namespace skyquilt::server
