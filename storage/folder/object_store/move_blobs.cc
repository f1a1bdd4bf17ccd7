#include "storage/folder/object_store/move_blobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>
#include <system_error>

#include "core/base/parallel_for.h"
#include "core/base/scoped_folder.h"
#include "core/base/try.h"
#include "storage/blobs/range_cache.h"
#include "storage/blobs/sha256.h"
#include "storage/catalogue/catalogue.h"
#include "storage/exports/pmtiles_writer.h"
#include "storage/files/publish_file.h"
#include "storage/folder/data_marker.h"
#include "storage/folder/disk_flights.h"
#include "storage/folder/object_store/settle_blobs.h"
#include "storage/jobs/job_queue.h"
#include "storage/jobs/map_products.h"

namespace skyquilt::storage {
namespace fs = std::filesystem;
namespace {

// The key of a map's mosaic.pmtiles.
std::string PackOf(const std::string& map) { return map.substr(0, map.rfind('/') + 1) + "mosaic.pmtiles"; }

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

// One archive at a time, below the data folder's incoming/. `maps`: the keys of each
// "flights/<id>/r<revision>/mosaic.mbtiles", that `from` can give as files. What `store` has a mosaic.pmtiles
// of is passed over.
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

constexpr int kMovedSideBySide = 4;

// What a flight's place holds beside its record and its previews, which stay in the folder.
bool IsMoved(const std::string& key) {
  const std::optional<FlightBlob> blob = FlightBlobOf(key);
  return blob && (blob->folder == "files" || RevisionOfFolder(blob->folder));
}

Result<std::vector<BlobInfo>> Moved(BlobStore& blobs) {
  SKYQUILT_TRY_ASSIGN(std::vector<BlobInfo> all, blobs.List("flights/"));
  std::erase_if(all, [](const BlobInfo& blob) { return !IsMoved(blob.key); });
  return all;
}

std::vector<std::string> MapsAmong(const std::vector<BlobInfo>& blobs) {
  std::vector<std::string> maps;
  for (const BlobInfo& blob : blobs)
    if (blob.key.ends_with("/mosaic.mbtiles")) maps.push_back(blob.key);
  return maps;
}

// What Put and PackMaps make anew wherever it is wanted: in a folder, tiles and mosaic.pmtiles itself are
// read out of the map beside it.
void LeavePacks(std::vector<BlobInfo>& blobs) {
  std::set<std::string> packs;
  for (const std::string& map : MapsAmong(blobs))
    packs.insert({PackOf(map), RangeSumsKey(PackOf(map)), RangeSumsKey(map)});
  std::erase_if(blobs, [&](const BlobInfo& blob) { return packs.contains(blob.key); });
}

// A move would hide what is missing: it is said before.
Result<void> CheckComplete(CatalogueDb& db, const std::vector<BlobInfo>& blobs, const BlobStore& from) {
  std::set<std::string> keys;
  for (const BlobInfo& blob : blobs) keys.insert(blob.key);
  const Catalogue catalogue(db);
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> ids, catalogue.FlightIds());
  for (const std::string& id : ids) {
    SKYQUILT_TRY_ASSIGN(const std::vector<StoredFile> files, catalogue.ListFiles(id));
    for (const StoredFile& file : files) {
      if (keys.contains(FilesPrefix(id) + file.stored_name)) continue;
      return Error{ErrorCode::kNotFound,
                   fmt::format("{} lacks {}{} ({}). See \"skyquilt data check\"; nothing was moved.",
                               from.Address(), FilesPrefix(id), file.stored_name, file.name),
                   ""};
    }
    SKYQUILT_TRY_ASSIGN(const std::vector<std::int64_t> revisions, catalogue.Revisions(id));
    for (const std::int64_t revision : revisions) {
      if (keys.contains(RevisionPrefix(id, revision) + "mosaic.mbtiles")) continue;
      return Error{ErrorCode::kNotFound,
                   fmt::format("{} lacks {}mosaic.mbtiles. See \"skyquilt data check\"; nothing was moved.",
                               from.Address(), RevisionPrefix(id, revision)),
                   ""};
    }
  }
  return {};
}

// True: it was copied; false: it was there.
Result<bool> MoveOne(const BlobInfo& blob, BlobStore& from, BlobStore& to) {
  SKYQUILT_TRY_ASSIGN(const std::string sum, Sha256OfBlob(from, blob));
  const auto is_there = [&]() -> Result<bool> {
    const Result<BlobInfo> copy = to.Find(blob.key);
    if (!copy && copy.error().code == ErrorCode::kNotFound) return false;
    if (!copy) return copy.error();
    if (copy->bytes != blob.bytes) return false;
    SKYQUILT_TRY_ASSIGN(const std::string sum_of_copy, Sha256OfBlob(to, *copy));
    return sum_of_copy == sum;
  };
  SKYQUILT_TRY_ASSIGN(const bool was_there, is_there());
  if (was_there) return false;
  SKYQUILT_TRY_ASSIGN(const LocalBlob local, from.Local(blob.key));
  SKYQUILT_TRY(to.Put(blob.key, local.path));
  SKYQUILT_TRY_ASSIGN(const bool is_same, is_there());
  if (is_same) return true;
  return Error{
      ErrorCode::kCorrupt,
      fmt::format("The copy of {} at {} is not the same as the original. Nothing was removed; run the "
                  "same command again.",
                  blob.key, to.Address()),
      ""};
}

// Whoever is at work puts a map where nobody will look for it, and the parts of a flight are not moved.
Result<void> CheckNobodyWorks(CatalogueDb& db) {
  SKYQUILT_TRY_ASSIGN(const std::vector<JobQueue::LiveLease> leases, JobQueue(db).LiveLeases(Now()));
  if (leases.empty()) return {};
  return Error{ErrorCode::kConflict,
               fmt::format("A job of flight {} is running. Let it end, or cancel it, stop all servers and "
                           "workers and run the command again; a worker that was killed counts for {} s. "
                           "Nothing was removed.",
                           leases.front().flight_id, kLeaseTime.count()),
               ""};
}

// While those that were listed were copied.
Result<void> CheckNothingCame(BlobStore& from, const std::vector<BlobInfo>& listed) {
  std::set<std::string> keys;
  for (const BlobInfo& blob : listed) keys.insert(blob.key);
  SKYQUILT_TRY_ASSIGN(const std::vector<BlobInfo> blobs, Moved(from));
  for (const BlobInfo& blob : blobs) {
    if (keys.contains(blob.key)) continue;
    return Error{ErrorCode::kConflict,
                 fmt::format("{} came to {} while the others were copied. Stop all servers and workers, and "
                             "run the command again. Nothing was removed.",
                             blob.key, from.Address()),
                 ""};
  }
  return {};
}

// `blobs`: whose copies were held against them, and packs of such.
Result<std::int64_t> RemoveSource(BlobStore& from, const std::vector<BlobInfo>& blobs) {
  for (const BlobInfo& blob : blobs) {
    SKYQUILT_TRY(from.Remove(blob.key));
  }
  // Others may have the place now.
  if (!from.IsFolder()) {
    SKYQUILT_TRY(from.Remove("skyquilt-data.json"));
  }
  return static_cast<std::int64_t>(blobs.size());
}

}  // namespace

Result<MoveReport> MoveBlobs(const DataDir& dir, const std::string& catalogue_id, CatalogueDb& db,
                             BlobStore& from, BlobStore& to, bool removes_source, Progress& progress) {
  SKYQUILT_TRY(db.HoldAlone());
  SKYQUILT_TRY(CheckNobodyWorks(db));
  SKYQUILT_TRY_ASSIGN(const std::optional<std::string> settled, SettledAt(dir));
  const std::string lies_at = settled.value_or("");
  const std::string moves_to = to.IsFolder() ? "" : to.Address();
  // A move that was done already has only the originals left to remove.
  const bool is_done = lies_at == moves_to;
  if (!is_done && lies_at != (from.IsFolder() ? "" : from.Address())) {
    return Error{ErrorCode::kConflict,
                 fmt::format("The photos and maps of {} lie at {}, not at {}.", dir.root().string(),
                             settled ? *settled : dir.root().string(), from.Address()),
                 ""};
  }
  for (BlobStore* place : {&from, &to}) {
    if (place->IsFolder()) continue;
    SKYQUILT_TRY(ClaimBlobs(catalogue_id, *place));
  }
  MoveReport report;
  SKYQUILT_TRY_ASSIGN(const std::vector<BlobInfo> listed, Moved(from));
  std::vector<BlobInfo> blobs = listed;
  if (!is_done) {
    SKYQUILT_TRY(CheckComplete(db, blobs, from));
  }
  if (to.IsFolder()) LeavePacks(blobs);
  for (const BlobInfo& blob : blobs) report.bytes += blob.bytes;
  progress.BeginStage("move");
  std::mutex mutex;
  std::int64_t bytes_done = 0;
  const auto move = [&](std::size_t i) -> Result<void> {
    SKYQUILT_TRY_ASSIGN(const bool is_copied, MoveOne(blobs[i], from, to));
    const std::lock_guard lock(mutex);
    ++(is_copied ? report.copied : report.there_already);
    bytes_done += blobs[i].bytes;
    progress.Report(
        static_cast<double>(bytes_done) / static_cast<double>(std::max<std::int64_t>(1, report.bytes)),
        fmt::format("{} of {} files, {:.1f} of {:.1f} MB", report.copied + report.there_already, blobs.size(),
                    static_cast<double>(bytes_done) / 1e6, static_cast<double>(report.bytes) / 1e6));
    return {};
  };
  SKYQUILT_TRY(ParallelTry(blobs.size(), kMovedSideBySide, move));
  if (!to.IsFolder()) {
    SKYQUILT_TRY_ASSIGN(report.pack, PackMaps(dir, MapsAmong(blobs), from, to, progress));
  }
  SKYQUILT_TRY(CheckNobodyWorks(db));
  SKYQUILT_TRY(CheckNothingCame(from, listed));
  if (db.IsShared()) {
    SKYQUILT_TRY(ChangeCatalogueBlobs(*db.Lock(), to.IsFolder() ? kInDataFolder : moves_to));
  }
  SKYQUILT_TRY(ForgetProducts(*db.Lock()));
  SKYQUILT_TRY(SettleAt(dir, moves_to));
  if (removes_source) {
    SKYQUILT_TRY_ASSIGN(report.removed, RemoveSource(from, listed));
  }
  return report;
}

}  // namespace skyquilt::storage
