// CheckMaps: holds the files of all maps against the SHA-256 that the catalogue has kept of them since their
// jobs put them there (storage/jobs/map_products), and adds what is not the same, or not there. Reads every
// byte of them, past all caches. Changes nothing. Errors: those of catalogue and blobs; kCancelled.
#pragma once

#include "core/base/progress.h"
#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/db/catalogue_db.h"
#include "storage/folder/check_data.h"

namespace skyquilt::storage {

Result<void> CheckMaps(CatalogueDb& db, BlobStore& blobs, DataCheck& check, Progress& progress);

}  // namespace skyquilt::storage
