// SettleBlobs: photos and maps of a catalogue lie in one place, and that place is its alone. Where they lie
// elsewhere than in the data folder, the folder says where (blobs.json), a catalogue in PostgreSQL says
// where, and the place says whose they are (skyquilt-data.json, with the catalogue's id), so that neither a
// forgotten option nor a mistyped one shows flights without their photos, takes jobs whose photos it has not,
// or sweeps those of another. Before anything is read, written or claimed there. Any process. Errors:
// kConflict, with what to do; those of the blobs.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/blobs/open_blobs.h"
#include "storage/db/catalogue_db.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

// For a folder that is the catalogue's (its marker has the same id).
Result<void> SettleBlobs(const DataDir& dir, CatalogueDb& db, BlobStore& blobs);

// A place with what there is to know of it before a folder or catalogue is made beside it. Nothing is
// written.
Result<CataloguePlace> WithFilesAt(CataloguePlace place, const BlobPlace& blobs);
// kConflict where the photos of this catalogue do not lie at `address` (empty: in the data folder), which is
// `owner`'s.
Result<void> CheckBlobsOf(SqlConnection& db, const std::optional<std::string>& catalogue_id,
                          const std::string& address, const std::optional<std::string>& owner);
// What a new catalogue is refused with beside a place that has another's.
Error OfAnotherCatalogue(const std::string& address, const std::string& owner,
                         const std::optional<std::string>& catalogue_id);

// What the folder says; absent: they lie in it.
Result<std::optional<std::string>> SettledAt(const DataDir& dir);
// Says so from now on; empty: in the folder itself.
Result<void> SettleAt(const DataDir& dir, const std::string& address);
// Takes the place for a catalogue. kConflict where it is another's.
Result<void> ClaimBlobs(const std::string& catalogue_id, BlobStore& blobs);

}  // namespace skyquilt::storage
