#include "storage/folder/object_store/sweep_blobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "core/base/try.h"
#include "storage/db/ids.h"
#include "storage/folder/disk_flights.h"

namespace skyquilt::storage {
namespace {

Result<std::set<std::string>> ShownFolders(const Catalogue& catalogue, const std::string& flight_id) {
  SKYQUILT_TRY_ASSIGN(const std::vector<std::int64_t> revisions, catalogue.Revisions(flight_id));
  std::set<std::string> folders;
  for (const std::int64_t revision : revisions) folders.insert(RevisionFolderName(revision));
  return folders;
}

// Workers that had not heard of a deletion put parts of the flight after it: for a day each sweep looks
// again.
Result<std::set<std::string>> EndDeletions(BlobStore& blobs, const std::set<std::string>& known,
                                           std::chrono::system_clock::time_point forgotten,
                                           SweepReport& report) {
  SKYQUILT_TRY_ASSIGN(const std::vector<BlobInfo> begun, blobs.List(std::string(kDeletedPrefix)));
  std::set<std::string> gone;
  for (const BlobInfo& marker : begun) {
    const std::string id = marker.key.substr(kDeletedPrefix.size());
    if (!IsId(id) || known.contains(id)) continue;
    SKYQUILT_TRY_ASSIGN(const int removed, blobs.RemoveBelow(FlightPrefix(id)));
    report.removed += removed;
    gone.insert(id);
    if (marker.changed <= forgotten) SKYQUILT_TRY(blobs.Remove(marker.key));
  }
  return gone;
}

// Of what is in a flight's folder in the store, a map that the catalogue never made.
std::string OfNewerCatalogue(const BlobStore& blobs, const std::string& flight_id, std::int64_t revision) {
  return fmt::format(
      "{}{} is a map that the catalogue never made: the catalogue is an older copy, or another server uses the "
      "same store",
      blobs.Address(), RevisionPrefix(flight_id, revision));
}

}  // namespace

Result<int> SweepRevisionBlobs(BlobStore& blobs, const Catalogue& catalogue, const std::string& flight_id) {
  // Listed before the catalogue is read: what comes meanwhile is not in the list.
  SKYQUILT_TRY_ASSIGN(const std::vector<BlobInfo> products, blobs.List(FlightPrefix(flight_id) + "r"));
  SKYQUILT_TRY_ASSIGN(const std::set<std::string> shown, ShownFolders(catalogue, flight_id));
  SKYQUILT_TRY_ASSIGN(const std::int64_t next, catalogue.NextRevision(flight_id));
  std::set<std::string> unshown;
  for (const BlobInfo& product : products) {
    const std::optional<FlightBlob> name = FlightBlobOf(product.key);
    const std::optional<std::int64_t> revision = name ? RevisionOfFolder(name->folder) : std::nullopt;
    if (!revision) continue;
    if (*revision >= next)
      return Error{
          ErrorCode::kConflict,
          OfNewerCatalogue(blobs, flight_id, *revision) +
              ". Nothing was removed or made. Whoever runs the server can put back the latest copy of "
              "the catalogue.",
          ""};
    if (!shown.contains(name->folder)) unshown.insert(name->folder);
  }
  int removed = 0;
  for (const std::string& folder : unshown) {
    SKYQUILT_TRY_ASSIGN(const int count, blobs.RemoveBelow(FlightPrefix(flight_id) + folder + "/"));
    removed += count;
  }
  return removed;
}

Result<SweepReport> SweepBlobs(BlobStore& blobs, const Catalogue& catalogue, const JobQueue& queue, Time now,
                               std::chrono::seconds orphan_age) {
  SKYQUILT_TRY_ASSIGN(const auto store_time, TimeOfStore(blobs));
  SKYQUILT_TRY_ASSIGN(const std::vector<BlobInfo> all, blobs.List("flights/"));
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> ids, catalogue.FlightIds());
  SKYQUILT_TRY_ASSIGN(const std::vector<JobQueue::LiveLease> leases, queue.LiveLeases(now));
  const std::set<std::string> known(ids.begin(), ids.end());
  std::set<std::string> live;
  for (const auto& lease : leases) live.insert(lease.flight_id);
  SweepReport report;
  SKYQUILT_TRY_ASSIGN(const std::set<std::string> gone,
                      EndDeletions(blobs, known, store_time - orphan_age, report));

  std::map<std::string, std::vector<std::pair<FlightBlob, std::string>>> old;  // by flight: names and keys
  std::map<std::string, std::int64_t> newest;                                  // map of a flight, at any age
  std::set<std::string> unknown;
  for (const BlobInfo& blob : all) {
    const std::optional<FlightBlob> name = FlightBlobOf(blob.key);
    if (!name) continue;
    std::int64_t& of_flight = newest[name->flight_id];
    of_flight = std::max(of_flight, RevisionOfFolder(name->folder).value_or(0));
    if (gone.contains(name->flight_id) || store_time - blob.changed < orphan_age) continue;
    if (!known.contains(name->flight_id)) {
      unknown.insert(name->flight_id);
    } else {
      old[name->flight_id].emplace_back(*name, blob.key);
    }
  }
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> of_use, queue.UnitsOfUse(now));
  std::set<std::string> cut;  // folders of parts that somebody may still need
  for (const std::string& units_of : of_use) cut.insert(UnitsFolderName(units_of));
  const std::string lost = fmt::format("lost/{}/", ToUs(now) / 1'000'000);
  for (const auto& [flight_id, blobs_of_flight] : old) {
    const Result<std::int64_t> next = catalogue.NextRevision(flight_id);
    if (!next && next.error().code == ErrorCode::kNotFound) continue;  // deleted just now
    if (!next) return next.error();
    if (newest[flight_id] >= *next) {
      report.moved.push_back(OfNewerCatalogue(blobs, flight_id, newest[flight_id]) +
                             "; all that is there of its flight stays");
      continue;
    }
    SKYQUILT_TRY_ASSIGN(const std::set<std::string> shown, ShownFolders(catalogue, flight_id));
    SKYQUILT_TRY_ASSIGN(const std::vector<StoredFile> files, catalogue.ListFiles(flight_id));
    std::set<std::string> stored;
    for (const StoredFile& file : files) stored.insert(file.stored_name);
    for (const auto& [name, key] : blobs_of_flight) {
      const bool is_unshown =
          RevisionOfFolder(name.folder) && !shown.contains(name.folder) && !live.contains(flight_id);
      const bool is_of_ended_job = IsUnitsFolder(name.folder) && !cut.contains(name.folder);
      if (is_unshown || is_of_ended_job) {
        SKYQUILT_TRY(blobs.Remove(key));
        ++report.removed;
      } else if (name.folder == "files" && !stored.contains(name.name)) {
        SKYQUILT_TRY(blobs.Copy(key, lost + key));
        SKYQUILT_TRY(blobs.Remove(key));
        report.moved.push_back(
            fmt::format("{}{} is no file of its flight and was moved to {}", blobs.Address(), key, lost));
      }
    }
  }
  if (!unknown.empty()) {
    report.moved.push_back(fmt::format(
        "{} has blobs of {} flights that are not in the catalogue, such as {}; they stay there, and "
        "\"skyquilt data check\" lists them",
        blobs.Address(), unknown.size(), *unknown.begin()));
  }
  return report;
}

}  // namespace skyquilt::storage
