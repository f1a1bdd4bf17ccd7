// CheckData: compares a data folder with its catalogue in both directions: files the catalogue lists and
// files on disk. Reads names and sizes. CheckMaps: the bytes of maps. Both change nothing. For a folder that
// no server uses at the moment. Errors: those of catalogue and blobs; kCancelled.
#pragma once

#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/db/catalogue_db.h"
#include "storage/files/data_dir.h"
#include "storage/folder/lost_folder.h"

namespace skyquilt::storage {

struct DataCheck {
  int flights = 0;  // in the catalogue
  int files = 0;
  int maps = 0;
  std::int64_t bytes = 0;
  std::vector<std::string> missing;  // in the catalogue, not (or not whole) on disk; a line each
  std::vector<std::string> unknown;  // on disk, not in the catalogue; a line each
  std::vector<std::string> changed;  // of maps, not as the catalogue knows them; a line each
  int maps_without_sums = 0;         // of which it knows nothing; both by CheckMaps
  std::vector<LostItem> lost;

  bool IsWell() const { return missing.empty() && unknown.empty() && changed.empty() && lost.empty(); }
};

// `blobs`: where photos and maps lie; absent: in the data folder.
Result<DataCheck> CheckData(const DataDir& dir, CatalogueDb& db, BlobStore* blobs = nullptr);

// Holds the files of all maps against the SHA-256 that the catalogue has kept of them since their
// jobs put them there (storage/jobs/map_products), and adds what is not the same, or not there. Reads every
// byte of them, past all caches.
Result<void> CheckMaps(CatalogueDb& db, BlobStore& blobs, DataCheck& check, Progress& progress);

}  // namespace skyquilt::storage
