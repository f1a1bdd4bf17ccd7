// PackMaps: maps that came from a folder get a mosaic.pmtiles beside their mosaic.mbtiles, so that their
// tiles are read out of a store by ranges. In a folder nothing needs one. Holds one archive at a time, below
// the data folder's incoming/. A map that cannot be packed (it is damaged, or the disk is full) is told of
// and stays as good as it was: it is fetched whole. For a folder that no server uses at the moment. Errors:
// those of both places; kIo, kCancelled.
#pragma once

#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

struct PackReport {
  int packed = 0;
  std::vector<std::string> left_whole;  // each map with the reason
};

// The key of a map's mosaic.pmtiles.
std::string PackOf(const std::string& map);

// `maps`: the keys of each "flights/<id>/r<revision>/mosaic.mbtiles", that `from` can give as files. What
// `store` has a mosaic.pmtiles of is passed over.
Result<PackReport> PackMaps(const DataDir& dir, const std::vector<std::string>& maps, BlobStore& from,
                            BlobStore& store, Progress& progress);

}  // namespace skyquilt::storage
