// MapPicture: a finished map as one small picture whose pixels have a known size on the ground, north up.
// Temporary files lie in `work_folder`. Blocking. Errors: those of storage::ExportMap and WriteThumbnail,
// kCorrupt.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/image/rgba_image.h"

namespace skyquilt::server {

inline constexpr int kReportPicturePx = 1600;  // longer side, unless somebody wants another

struct MapPicture {
  std::vector<std::uint8_t> webp;  // transparent where the map is empty
  int width_px = 0;
  int height_px = 0;
  double pixel_m = 0.0;
};

// The same before it is encoded.
struct MapPixels {
  image::RgbaImage image;
  double pixel_m = 0.0;
};
// `threads`: 0 = all cores.
Result<MapPixels> MakeMapPixels(const std::filesystem::path& map, int longer_side_px, int threads,
                                const std::filesystem::path& work_folder, Progress& progress);
MapPicture EncodeMapPicture(const MapPixels& pixels);

// How a sandboxed process gives them to its parent, which encodes them: a line of numbers, then the pixels as
// they are, so that nothing of that process is decoded outside it. Error: kCorrupt (not just as many as the
// numbers say).
inline constexpr std::size_t kMaxMapPixelBytes =
    std::size_t{4} * (kReportPicturePx + 64) * (kReportPicturePx + 64);
std::string ToBytes(const MapPixels& pixels);
Result<MapPixels> ParseMapPixels(std::string_view bytes);

// 1, 2 or 5 times a power of ten: the longest scale bar that is no longer than this.
double ScaleBarM(double most_m);

}  // namespace skyquilt::server
