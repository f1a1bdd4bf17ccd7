// ValidateMap: whether a map is sound, of ours or of anybody: an MBTiles (1.3), a PMTiles (3), a GeoTIFF with
// the layout of a cloud-optimised one, or the folder of a map of ours with what its files say of each other.
// Files are only read. Foreign bytes: every reader is bounded; not for processes that serve others. Blocking.
// Errors: kNotFound, kUnsupportedFormat (no map), kIo, kCancelled. What is wrong with a map is no error but a
// finding.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "storage/validation/file_verdict.h"

namespace skyquilt::storage {

struct ValidateOptions {
  bool quick = false;  // look into a sample of the pictures
};

Result<std::vector<FileVerdict>> ValidateMap(const std::filesystem::path& path,
                                             const ValidateOptions& options, Progress& progress);

// Of one file each; what they cannot even open is a finding too. Error: kCancelled.
Result<FileVerdict> ValidateMbtiles(const std::filesystem::path& path, const ValidateOptions& options,
                                    Progress& progress);
Result<FileVerdict> ValidatePmtiles(const std::filesystem::path& path, const ValidateOptions& options,
                                    Progress& progress);
Result<FileVerdict> ValidateGeotiff(const std::filesystem::path& path, const ValidateOptions& options,
                                    Progress& progress);

// What report.json, photos.geojson and the like say, against each other and against what was found of tiles.
// None where there is no such file.
std::vector<FileVerdict> ValidateReports(const std::filesystem::path& folder,
                                         const std::vector<FileVerdict>& tiles);

}  // namespace skyquilt::storage
