#include "storage/folder/object_store/pack_maps.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "core/base/scoped_folder.h"
#include "core/base/try.h"
#include "storage/exports/pmtiles_writer.h"
#include "storage/files/publish_file.h"

namespace skyquilt::storage {
namespace fs = std::filesystem;
namespace {

// True: the store had none and has one now.
Result<bool> PackOne(const std::string& map, const fs::path& folder, BlobStore& from, BlobStore& store,
                     PackReport& report) {
  const std::string key = PackOf(map);
  const Result<BlobInfo> there = store.Find(key);
  if (there) return false;
  if (there.error().code != ErrorCode::kNotFound) return there.error();
  SKYQUILT_TRY_ASSIGN(const LocalBlob local, from.Local(map));
  const fs::path archive = folder / "mosaic.pmtiles";
  SilentProgress silent;  // seconds a gigabyte
  const Result<void> written = WritePmtiles(local.path, archive, silent);
  if (!written) {
    report.left_whole.push_back(fmt::format("{}: {}", map, written.error().message));
    return false;
  }
  SKYQUILT_TRY(store.Put(key, archive));
  std::error_code ignored;  // the next one takes its place, or the folder goes as a whole
  fs::remove(archive, ignored);
  return true;
}

}  // namespace

std::string PackOf(const std::string& map) { return map.substr(0, map.rfind('/') + 1) + "mosaic.pmtiles"; }

Result<PackReport> PackMaps(const DataDir& dir, const std::vector<std::string>& maps, BlobStore& from,
                            BlobStore& store, Progress& progress) {
  PackReport report;
  if (maps.empty()) return report;
  progress.BeginStage("pack");
  const ScopedFolder folder(dir.Incoming() / dir.NewTemporaryName(kPackKind));
  std::error_code unmade;
  if (!fs::create_directory(folder.path(), unmade))
    return FileError("cannot make", folder.path(), unmade.value());
  for (std::size_t i = 0; i < maps.size(); ++i) {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "Stopped.", ""};
    SKYQUILT_TRY_ASSIGN(const bool is_new, PackOne(maps[i], folder.path(), from, store, report));
    if (is_new) ++report.packed;
    progress.Report(static_cast<double>(i + 1) / static_cast<double>(maps.size()),
                    fmt::format("{} of {} maps", i + 1, maps.size()));
  }
  return report;
}

}  // namespace skyquilt::storage
