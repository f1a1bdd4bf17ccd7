#include "storage/folder/sweep_exports.h"

#include <set>
#include <system_error>

#include "core/base/try.h"
#include "storage/blobs/flight_blobs.h"
#include "storage/db/ids.h"
#include "storage/folder/lost_folder.h"
#include "storage/folder/object_store/sweep_blobs.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

Result<std::set<std::string>> KnownExports(const MapExports& exports, const std::string& flight_id) {
  SKYQUILT_TRY_ASSIGN(const std::vector<MapExport> known, exports.List(flight_id));
  std::set<std::string> keys;
  for (const MapExport& one : known) keys.insert(ExportKey(one));
  return keys;
}

std::string ExportsPrefix(const std::string& flight_id) {
  return FlightPrefix(flight_id) + kExportsFolder + "/";
}

// As ExportKey names them: an id, and the ending of a format.
bool IsExportName(const fs::path& name) {
  return IsId(name.stem().string()) && name.has_extension() && !name.has_parent_path();
}

}  // namespace

Result<std::vector<std::string>> SweepExports(const DataDir& dir, const Catalogue& catalogue,
                                              const MapExports& exports, Time now) {
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> ids, catalogue.FlightIds());
  LostFolder lost(dir, now);
  std::vector<std::string> moved;
  for (const std::string& id : ids) {
    std::vector<fs::path> files;
    std::error_code missing;  // most flights have no exports
    for (const auto& entry : fs::directory_iterator(dir.Flight(id) / kExportsFolder, missing))
      files.push_back(entry.path());
    if (files.empty()) continue;
    SKYQUILT_TRY_ASSIGN(const std::set<std::string> known, KnownExports(exports, id));
    for (const fs::path& file : files) {
      if (!known.contains(ExportsPrefix(id) + file.filename().string()))
        moved.push_back(lost.Take(file, "is no export in the catalogue"));
    }
  }
  return moved;
}

Result<int> SweepExportBlobs(BlobStore& blobs, const Catalogue& catalogue, const MapExports& exports,
                             std::chrono::seconds orphan_age) {
  SKYQUILT_TRY_ASSIGN(const auto store_time, TimeOfStore(blobs));
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> ids, catalogue.FlightIds());
  int removed = 0;
  for (const std::string& id : ids) {
    SKYQUILT_TRY_ASSIGN(const std::vector<BlobInfo> there, blobs.List(ExportsPrefix(id)));
    if (there.empty()) continue;
    SKYQUILT_TRY_ASSIGN(const std::set<std::string> known, KnownExports(exports, id));
    for (const BlobInfo& blob : there) {
      if (known.contains(blob.key) || store_time - blob.changed < orphan_age) continue;
      if (!IsExportName(blob.key.substr(ExportsPrefix(id).size()))) continue;  // not ours
      SKYQUILT_TRY(blobs.Remove(blob.key));
      ++removed;
    }
  }
  return removed;
}

}  // namespace skyquilt::storage
