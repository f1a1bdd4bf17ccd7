// SettleBlobs: photos and maps of a catalogue lie in one place, and that place is its alone. Where they lie
// elsewhere than in the data folder, the folder says where (blobs.json), and the place says whose they are
// (skyquilt-data.json, with the catalogue's id), so that neither a forgotten option nor a mistyped one shows
// flights without their photos, or sweeps those of another. Before anything is read or written there. Any
// process. Errors: kConflict, with what to do; those of the blobs.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/folder/data_dir.h"

namespace skyquilt::storage {

// `catalogue_id`: the id of the catalogue, as in the data folder's marker.
Result<void> SettleBlobs(const DataDir& dir, const std::string& catalogue_id, BlobStore& blobs);

// What the folder says; absent: they lie in it.
Result<std::optional<std::string>> SettledAt(const DataDir& dir);
// Says so from now on; empty: in the folder itself.
Result<void> SettleAt(const DataDir& dir, const std::string& address);
// Takes the place for a catalogue. kConflict where it is another's.
Result<void> ClaimBlobs(const std::string& catalogue_id, BlobStore& blobs);

}  // namespace skyquilt::storage
