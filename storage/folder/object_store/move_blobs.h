// MoveBlobs: all photos and maps of a data folder to another place, from the folder to S3 or back. Each is
// copied, and the copy is held against the original by size and SHA-256 as its place gives it back; what is
// there already and is the same is not copied again, so that a move that was cut off goes on. In a store,
// maps get a mosaic.pmtiles beside their mosaic.mbtiles, so that their tiles are read by ranges; such packs
// are not copied back. Only when all are there does the folder say that they lie there
// (storage/folder/object_store/settle_blobs), and only then are the originals of these copies removed, if
// that was asked for. For a catalogue that no server and no worker uses at the moment. Errors: those of both
// places; kConflict (the other place is another catalogue's; somebody is at work, or something came
// meanwhile); kCorrupt (a copy that is not the same).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/db/catalogue_db.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

// A map that cannot be packed (it is damaged, or the disk is full) is told of and stays as good as it was: it
// is fetched whole.
struct PackReport {
  int packed = 0;
  std::vector<std::string> left_whole;  // each map with the reason
};

struct MoveReport {
  std::int64_t copied = 0;  // blobs
  std::int64_t there_already = 0;
  std::int64_t bytes = 0;    // of all
  std::int64_t removed = 0;  // originals
  PackReport pack;           // where it went to a store
};

// `catalogue_id`: of the folder. `db`: what is in it; every file and map that it names must be in `from`.
Result<MoveReport> MoveBlobs(const DataDir& dir, const std::string& catalogue_id, CatalogueDb& db,
                             BlobStore& from, BlobStore& to, bool removes_source, Progress& progress);

}  // namespace skyquilt::storage
