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

Result<int> SweepRevisions(const DataDir& dir, const Catalogue& catalogue, const std::string& flight_id) {
  const Result<std::vector<std::int64_t>> known = catalogue.Revisions(flight_id);
  if (!known) return known.error();
  std::set<std::string> keep = {"files"};
  for (const std::int64_t revision : *known) keep.insert(RevisionFolderName(revision));
  int removed = 0;
  for (const fs::path& entry : EntriesOf(dir.Flight(flight_id))) {
    if (!keep.contains(entry.filename().string())) removed += RemoveAll(entry);
  }
  return removed;
}

}  // namespace

Result<SweepReport> Sweep(const DataDir& dir, const Catalogue& catalogue, const JobQueue& queue, Time now) {
  const Result<std::vector<JobQueue::LiveLease>> leases = queue.LiveLeases(now);
  if (!leases) return leases.error();
  const Result<std::vector<std::string>> ids = catalogue.FlightIds();
  if (!ids) return ids.error();
  std::set<std::string> live_work;
  std::set<std::string> live_flights;
  for (const auto& lease : *leases) {
    live_work.insert(lease.work_name);
    live_flights.insert(lease.flight_id);
  }
  SweepReport report;
  for (const fs::path& entry : EntriesOf(dir.Incoming())) report.uploads += RemoveAll(entry);
  for (const fs::path& entry : EntriesOf(dir.Work())) {
    if (!live_work.contains(entry.filename().string())) report.work_folders += RemoveAll(entry);
  }
  const std::set<std::string> flights(ids->begin(), ids->end());
  for (const fs::path& entry : EntriesOf(dir.Flights())) {
    if (!flights.contains(entry.filename().string())) report.flights += RemoveAll(entry);
  }
  for (const std::string& id : *ids) {
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
