// MapPicture: a finished map as one small picture whose pixels have a known size on the ground, north up.
// Temporary files lie in `work_folder`. Blocking. Errors: those of storage::ExportMap and WriteThumbnail,
// kCorrupt.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"

namespace skyquilt::server {

inline constexpr int kReportPicturePx = 1600;  // longer side, unless somebody wants another

struct MapPicture {
  std::vector<std::uint8_t> webp;  // transparent where the map is empty
  int width_px = 0;
  int height_px = 0;
  double pixel_m = 0.0;
};

Result<MapPicture> MakeMapPicture(const std::filesystem::path& map, int longer_side_px,
                                  const std::filesystem::path& work_folder, Progress& progress);

// How one process gives it to another: a line of its numbers, then the picture. Of what comes from a
// sandboxed process nothing is believed: kCorrupt where the numbers are no picture's or the bytes no WebP.
std::string ToBytes(const MapPicture& picture);
Result<MapPicture> ParseMapPicture(std::string_view bytes);

// 1, 2 or 5 times a power of ten: the longest scale bar that is no longer than this.
double ScaleBarM(double most_m);

}  // namespace skyquilt::server
