// ExportMap: a finished map as one file, as an ExportRequest wants it. What it takes over from the map
// (tiles, the whole GeoTIFF) is copied byte for byte; pixels are resampled only for another coordinate system
// or resolution of a GeoTIFF, and encoded anew only there and on the boundary. Deterministic but for GDAL's
// version, where values are warped. Temporary files lie in `work_folder` and beside `path`; `path` is
// published by rename. Memory: some 150 MiB a thread (warped/warp_tiles.h), of values GDAL's caches.
// Blocking. Errors: those of CheckExport, kIo, kOutOfSpace, kCorrupt, kCancelled.
#pragma once

#include <filesystem>
#include <optional>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "storage/exports/custom/export_request.h"

namespace skyquilt::storage {

struct ExportSource {
  std::filesystem::path mbtiles;
  std::filesystem::path cog;    // of the same map; empty: made of the tiles where it is asked for
  std::filesystem::path bands;  // bands.tif; empty: it has its colours alone
  double gsd_m = 0.0;           // of its photos; 0: not known
  bool is_placed = true;
};

struct ExportOptions {
  int quality = 85;
  int threads = 0;  // 0 = all cores
};

Result<void> ExportMap(const ExportSource& source, const ExportRequest& request,
                       const std::filesystem::path& work_folder, const std::filesystem::path& path,
                       const ExportOptions& options, Progress& progress);

// What the folder of a finished map ("skyquilt stitch -o", a revision of the server) or a lone MBTiles gives
// for it. Errors: kNotFound (no map there).
Result<ExportSource> ExportSourceOf(const std::filesystem::path& map);

// What is to be known of the file beside that it was made (RemarkOnCrs).
Result<std::optional<flight::Remark>> RemarkOnExport(const ExportSource& source,
                                                     const ExportRequest& request);

// How many pixels of the map the values of an index are made for: what an export of them takes while it is
// made.
Result<double> PixelsOfExport(const std::filesystem::path& map, const ExportRequest& request);

}  // namespace skyquilt::storage
