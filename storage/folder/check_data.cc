#include "storage/folder/check_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>

#include "core/base/parallel_for.h"
#include "core/base/try.h"
#include "storage/blobs/sha256.h"
#include "storage/catalogue/catalogue.h"
#include "storage/catalogue/previews.h"
#include "storage/db/ids.h"
#include "storage/folder/disk_flights.h"
#include "storage/jobs/map_products.h"

namespace skyquilt::storage {
namespace {

namespace fs = std::filesystem;

void CompareFiles(const std::string& flight_id, const std::vector<StoredFile>& known, const DiskFlight& disk,
                  DataCheck& check) {
  std::map<std::string, std::int64_t> there;
  for (const DiskFile& file : disk.files) there[file.stored_name] = file.bytes;
  for (const StoredFile& file : known) {
    ++check.files;
    check.bytes += file.bytes;
    const auto found = there.find(file.stored_name);
    if (found == there.end()) {
      check.missing.push_back(
          fmt::format("flights/{}/files/{} ({})", flight_id, file.stored_name, file.name));
      continue;
    }
    if (found->second != file.bytes) {
      check.missing.push_back(fmt::format("flights/{}/files/{} ({}): {} bytes instead of {}", flight_id,
                                          file.stored_name, file.name, found->second, file.bytes));
    }
    there.erase(found);
  }
  for (const auto& [stored_name, bytes] : there) {
    check.unknown.push_back(fmt::format("flights/{}/files/{} ({} bytes)", flight_id, stored_name, bytes));
  }
}

void CompareMaps(const std::string& flight_id, const std::vector<std::int64_t>& known, const DiskFlight& disk,
                 DataCheck& check) {
  std::set<std::int64_t> there(disk.revisions.begin(), disk.revisions.end());
  for (const std::int64_t revision : known) {
    ++check.maps;
    if (there.erase(revision) == 0) {
      check.missing.push_back(fmt::format("flights/{}/{} (a map)", flight_id, RevisionFolderName(revision)));
    }
  }
  for (const std::int64_t revision : there) {
    check.unknown.push_back(fmt::format("flights/{}/{} (a map)", flight_id, RevisionFolderName(revision)));
  }
}

}  // namespace

Result<DataCheck> CheckData(const DataDir& dir, CatalogueDb& db, BlobStore* blobs) {
  const Catalogue catalogue(db);
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> ids, catalogue.FlightIds());
  std::map<std::string, DiskFlight> disk;
  std::vector<DiskFlight> found_flights = FlightsOnDisk(dir.Flights());
  if (blobs != nullptr && !blobs->IsFolder()) {
    SKYQUILT_TRY_ASSIGN(found_flights, FlightsInBlobs(*blobs));
  }
  for (DiskFlight& flight : found_flights) {
    std::string id = flight.id;
    disk.emplace(std::move(id), std::move(flight));
  }
  DataCheck check;
  for (const std::string& id : ids) {
    ++check.flights;
    SKYQUILT_TRY_ASSIGN(const std::vector<StoredFile> files, catalogue.ListFiles(id));
    SKYQUILT_TRY_ASSIGN(const std::vector<std::int64_t> revisions, catalogue.Revisions(id));
    const auto found = disk.find(id);
    const DiskFlight on_disk = found == disk.end() ? DiskFlight{} : found->second;
    CompareFiles(id, files, on_disk, check);
    CompareMaps(id, revisions, on_disk, check);
    if (found != disk.end()) disk.erase(found);
  }
  for (const auto& [id, flight] : disk) {
    check.unknown.push_back(
        fmt::format("flights/{} ({} files, {} maps)", id, flight.files.size(), flight.revisions.size()));
  }
  std::error_code none;  // a folder that is not there holds nothing
  for (const auto& entry : fs::directory_iterator(dir.Flights(), none)) {
    const std::string name = entry.path().filename().string();
    std::error_code gone;
    if (!IsId(name) || !entry.is_directory(gone)) check.unknown.push_back("flights/" + name);
  }
  std::sort(check.unknown.begin(), check.unknown.end());
  check.lost = ListLost(dir);
  return check;
}

namespace {

constexpr int kComparedSideBySide = 4;

// Under their keys.
Result<std::vector<MapProduct>> AllProducts(CatalogueDb& db, DataCheck& check) {
  const Catalogue catalogue(db);
  std::vector<MapProduct> all;
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> ids, catalogue.FlightIds());
  for (const std::string& id : ids) {
    SKYQUILT_TRY_ASSIGN(const std::vector<std::int64_t> revisions, catalogue.Revisions(id));
    for (const std::int64_t revision : revisions) {
      SKYQUILT_TRY_ASSIGN(std::vector<MapProduct> products, KnownProducts(db, id, revision));
      if (products.empty()) ++check.maps_without_sums;
      for (MapProduct& product : products)
        all.push_back({RevisionPrefix(id, revision) + product.name, std::move(product.sha256)});
    }
  }
  return all;
}

}  // namespace

Result<void> CheckMaps(CatalogueDb& db, BlobStore& blobs, DataCheck& check, Progress& progress) {
  SKYQUILT_TRY_ASSIGN(const std::vector<MapProduct> products, AllProducts(db, check));
  progress.BeginStage("compare");
  std::mutex mutex;
  std::size_t done = 0;
  const auto compare = [&](std::size_t i) -> Result<void> {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The check was stopped.", ""};
    const std::string &key = products[i].name, &sha256 = products[i].sha256;
    const auto read = [&]() -> Result<std::string> {
      SKYQUILT_TRY_ASSIGN(const BlobInfo blob, blobs.Find(key));
      return Sha256OfBlob(blobs, blob);
    };
    const Result<std::string> sum = read();
    const std::lock_guard lock(mutex);
    if (!sum && sum.error().code == ErrorCode::kNotFound) {
      check.missing.push_back(key + " (of a map)");
    } else if (!sum && sum.error().code == ErrorCode::kCorrupt) {
      check.changed.push_back(fmt::format("{}: {}", key, sum.error().message));
    } else if (!sum) {
      return sum.error();
    } else if (*sum != sha256) {
      check.changed.push_back(fmt::format("{}: SHA-256 {} instead of {}", key, *sum, sha256));
    }
    ++done;
    progress.Report(static_cast<double>(done) / static_cast<double>(products.size()),
                    fmt::format("{} of {} files", done, products.size()));
    return {};
  };
  SKYQUILT_TRY(ParallelTry(products.size(), kComparedSideBySide, compare));
  std::sort(check.changed.begin(), check.changed.end());
  return {};
}

}  // namespace skyquilt::storage
