#include "storage/folder/sweep.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <system_error>

#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/folder/lost_folder.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

// What this server writes below incoming/.
constexpr const char* kIncomingKinds[] = {kUploadKind, kUnpackKind, kExportKind, kImportKind, kPackKind};

std::vector<fs::path> EntriesOf(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code missing;  // a folder that is not there has nothing to sweep
  for (const auto& entry : fs::directory_iterator(folder, missing)) entries.push_back(entry.path());
  std::sort(entries.begin(), entries.end());
  return entries;
}

// Counts what is really gone.
int RemoveAll(const fs::path& path) {
  std::error_code error;
  fs::remove_all(path, error);
  return error ? 0 : 1;
}

bool IsPreviewName(const std::string& name) {
  const std::string_view prefix = kPreviewFolderPrefix;
  return name.starts_with(prefix) && IsId(std::string_view(name).substr(prefix.size()));
}

Result<void> TakeUnknown(const DataDir& dir, const Catalogue& catalogue, const std::string& flight_id,
                         LostFolder& lost, SweepReport& report) {
  SKYQUILT_TRY_ASSIGN(const std::vector<std::int64_t> known, catalogue.Revisions(flight_id));
  std::set<std::string> keep = {"files", kFlightRecordName, kExportsFolder};
  for (const std::int64_t revision : known) keep.insert(RevisionFolderName(revision));
  for (const fs::path& entry : EntriesOf(dir.Flight(flight_id))) {
    const std::string name = entry.filename().string();
    if (!keep.contains(name) && !IsPreviewName(name)) {
      report.moved.push_back(lost.Take(entry, "is no map that its flight shows"));
    }
  }
  return {};
}

// A work folder of a job that the catalogue knows and that has ended.
Result<bool> IsOfEndedJob(const JobQueue& queue, const std::string& work_name) {
  const std::string id = JobOfWorkName(work_name);
  if (!IsId(id)) return false;
  return queue.HasEnded(id);
}

Result<SweepReport> SweepWorkTo(const DataDir& dir, const JobQueue& queue, Time now, LostFolder& lost) {
  // Listed before the leases are read: a folder that a new lease makes meanwhile is not in the list.
  const std::vector<fs::path> entries = EntriesOf(dir.Work());
  SKYQUILT_TRY_ASSIGN(const std::vector<JobQueue::LiveLease> leases, queue.LiveLeases(now));
  std::set<std::string> live;
  for (const auto& lease : leases) live.insert(lease.work_name);
  // What a dead attempt left lets the next one go on from there.
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> unfinished, queue.UnfinishedJobs());
  const std::set<std::string> jobs(unfinished.begin(), unfinished.end());
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> of_use, queue.UnitsOfUse(now));
  for (const std::string& units_of : of_use) live.insert(UnitsWorkName(units_of));
  SweepReport report;
  for (const fs::path& entry : entries) {
    const std::string name = entry.filename().string();
    if (live.contains(name) || jobs.contains(JobOfWorkName(name))) continue;
    SKYQUILT_TRY_ASSIGN(const bool is_ended, IsOfEndedJob(queue, name));
    const bool is_of_units = IsUnitsWork(name) && IsId(JobOfWorkName(name));
    if (is_ended || is_of_units || dir.IsTemporaryName(kDeletedKind, name)) {
      report.removed += RemoveAll(entry);
    } else {
      report.moved.push_back(lost.Take(entry, "is of no job in the catalogue"));
    }
  }
  return report;
}

}  // namespace

Result<SweepReport> SweepRevisions(const DataDir& dir, const Catalogue& catalogue,
                                   const std::string& flight_id, Time now) {
  LostFolder lost(dir, now);
  SweepReport report;
  SKYQUILT_TRY(TakeUnknown(dir, catalogue, flight_id, lost, report));
  return report;
}

int SweepPreviews(const DataDir& dir, const std::string& flight_id, const std::string& keep) {
  int removed = 0;
  for (const fs::path& entry : EntriesOf(dir.Flight(flight_id))) {
    const std::string name = entry.filename().string();
    if (IsPreviewName(name) && name != keep) removed += RemoveAll(entry);
  }
  return removed;
}

Result<SweepReport> SweepWork(const DataDir& dir, const JobQueue& queue, Time now) {
  LostFolder lost(dir, now);
  return SweepWorkTo(dir, queue, now, lost);
}

Result<SweepReport> Sweep(const DataDir& dir, const Catalogue& catalogue, const JobQueue& queue,
                          const Previews& previews, Time now) {
  SKYQUILT_TRY_ASSIGN(const std::vector<JobQueue::LiveLease> leases, queue.LiveLeases(now));
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> ids, catalogue.FlightIds());
  std::set<std::string> live_flights;
  for (const auto& lease : leases) live_flights.insert(lease.flight_id);
  LostFolder lost(dir, now);
  SweepReport report;
  SKYQUILT_TRY_ASSIGN(const SweepReport work, SweepWorkTo(dir, queue, now, lost));
  report.Add(work);
  for (const fs::path& entry : EntriesOf(dir.Incoming())) {
    const std::string name = entry.filename().string();
    const bool is_ours = std::any_of(std::begin(kIncomingKinds), std::end(kIncomingKinds),
                                     [&](const char* kind) { return dir.IsTemporaryName(kind, name); });
    if (is_ours) {
      report.removed += RemoveAll(entry);
    } else {
      report.moved.push_back(lost.Take(entry, "is no upload of this server"));
    }
  }
  const std::set<std::string> flights(ids.begin(), ids.end());
  for (const fs::path& entry : EntriesOf(dir.Flights())) {
    if (!flights.contains(entry.filename().string())) {
      report.moved.push_back(lost.Take(entry, "is no flight in the catalogue"));
    }
  }
  for (const std::string& id : ids) {
    SKYQUILT_TRY_ASSIGN(const std::optional<Preview> preview, previews.Find(id));
    report.removed += SweepPreviews(dir, id, preview ? preview->folder : "");
    if (live_flights.contains(id)) continue;
    SKYQUILT_TRY_ASSIGN(const std::vector<StoredFile> files, catalogue.ListFiles(id));
    std::set<std::string> keep;
    for (const StoredFile& file : files) keep.insert(file.stored_name);
    for (const fs::path& entry : EntriesOf(dir.Files(id))) {
      if (!keep.contains(entry.filename().string())) {
        report.moved.push_back(lost.Take(entry, "is no file of its flight"));
      }
    }
    SKYQUILT_TRY(TakeUnknown(dir, catalogue, id, lost, report));
  }
  return report;
}

namespace {

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
