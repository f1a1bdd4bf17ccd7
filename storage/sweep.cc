#include "storage/sweep.h"

#include <algorithm>
#include <set>
#include <string>
#include <system_error>
#include <vector>

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

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

}  // namespace

Result<int> SweepRevisions(const DataDir& dir, const Catalogue& catalogue, const std::string& flight_id) {
  const Result<std::vector<std::int64_t>> known = catalogue.Revisions(flight_id);
  if (!known) return known.error();
  std::set<std::string> keep = {"files"};
  for (const std::int64_t revision : *known) keep.insert(RevisionFolderName(revision));
  int removed = 0;
  for (const fs::path& entry : EntriesOf(dir.Flight(flight_id))) {
    const std::string name = entry.filename().string();
    if (!keep.contains(name) && !name.starts_with(kPreviewFolderPrefix)) removed += RemoveAll(entry);
  }
  return removed;
}

int SweepPreviews(const DataDir& dir, const std::string& flight_id, const std::string& keep) {
  int removed = 0;
  for (const fs::path& entry : EntriesOf(dir.Flight(flight_id))) {
    const std::string name = entry.filename().string();
    if (name.starts_with(kPreviewFolderPrefix) && name != keep) removed += RemoveAll(entry);
  }
  return removed;
}

Result<int> SweepWork(const DataDir& dir, const JobQueue& queue, Time now) {
  // Listed before the leases are read: a folder that a new lease makes meanwhile is not in the list.
  const std::vector<fs::path> entries = EntriesOf(dir.Work());
  const Result<std::vector<JobQueue::LiveLease>> leases = queue.LiveLeases(now);
  if (!leases) return leases.error();
  std::set<std::string> live;
  for (const auto& lease : *leases) live.insert(lease.work_name);
  // What a dead attempt left lets the next one go on from there.
  const Result<std::vector<std::string>> unfinished = queue.UnfinishedJobs();
  if (!unfinished) return unfinished.error();
  const std::set<std::string> jobs(unfinished->begin(), unfinished->end());
  int removed = 0;
  for (const fs::path& entry : entries) {
    const std::string name = entry.filename().string();
    if (!live.contains(name) && !jobs.contains(JobOfWorkName(name))) removed += RemoveAll(entry);
  }
  return removed;
}

Result<SweepReport> Sweep(const DataDir& dir, const Catalogue& catalogue, const JobQueue& queue,
                          const Previews& previews, Time now) {
  const Result<std::vector<JobQueue::LiveLease>> leases = queue.LiveLeases(now);
  if (!leases) return leases.error();
  const Result<std::vector<std::string>> ids = catalogue.FlightIds();
  if (!ids) return ids.error();
  std::set<std::string> live_flights;
  for (const auto& lease : *leases) live_flights.insert(lease.flight_id);
  SweepReport report;
  const Result<int> work = SweepWork(dir, queue, now);
  if (!work) return work.error();
  report.work_folders = *work;
  for (const fs::path& entry : EntriesOf(dir.Incoming())) report.uploads += RemoveAll(entry);
  const std::set<std::string> flights(ids->begin(), ids->end());
  for (const fs::path& entry : EntriesOf(dir.Flights())) {
    if (!flights.contains(entry.filename().string())) report.flights += RemoveAll(entry);
  }
  for (const std::string& id : *ids) {
    const Result<std::optional<Preview>> preview = previews.Find(id);
    if (!preview) return preview.error();
    report.previews += SweepPreviews(dir, id, *preview ? (*preview)->folder : "");
    if (live_flights.contains(id)) continue;
    const Result<std::vector<StoredFile>> files = catalogue.ListFiles(id);
    if (!files) return files.error();
    std::set<std::string> keep;
    for (const StoredFile& file : *files) keep.insert(file.stored_name);
    for (const fs::path& entry : EntriesOf(dir.Files(id))) {
      if (!keep.contains(entry.filename().string())) report.files += RemoveAll(entry);
    }
    const Result<int> revisions = SweepRevisions(dir, catalogue, id);
    if (!revisions) return revisions.error();
    report.revisions += *revisions;
  }
  return report;
}

}  // namespace skyquilt::storage
