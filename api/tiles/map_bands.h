// MapBands: the bands beside maps (bands.tif), opened where the first asks, which may have to fetch them. Any
// thread. Errors: kCorrupt, kIo, and those of fetching.
#pragma once

#include <memory>

#include "storage/blobs/blob_store.h"
#include "storage/caches/tileset_cache.h"
#include "storage/rasters/band_raster.h"
#include "storage/rasters/open_rasters.h"

namespace skyquilt::api {

class MapBands {
 public:
  explicit MapBands(storage::BlobStore& blobs) : blobs_(blobs) {}
  // Null: the map has its colours alone.
  Result<std::shared_ptr<storage::BandRaster>> Of(const storage::Tileset& tileset);
  // Opening them fetches nothing large.
  bool AreHere() const { return blobs_.IsFolder(); }

 private:
  storage::BlobStore& blobs_;
  storage::OpenRasters<storage::BandRaster> opened_;
};

}  // namespace skyquilt::api
