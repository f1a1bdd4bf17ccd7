// BandRasters: the bands of maps, opened once and kept while they are read: of the kMaxOpen asked for last.
// That a map has none is remembered too, since a revision never changes. Any thread. Errors: those of finding
// the file and of opening it, which are told to whoever asks and tried again next time.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"
#include "storage/rasters/band_raster.h"

namespace skyquilt::storage {

class BandRasters {
 public:
  static constexpr std::size_t kMaxOpen = 64;

  // Null: the map has none. `find` says where the file is; kNotFound: nowhere.
  Result<std::shared_ptr<BandRaster>> Get(const std::string& flight_id, std::int64_t revision,
                                          const std::function<Result<LocalBlob>()>& find);

 private:
  struct Opened {
    std::string flight_id;
    std::int64_t revision = 0;
    std::shared_ptr<BandRaster> raster;
  };
  std::mutex mutex_;
  std::list<Opened> opened_;  // the last asked for first
};

}  // namespace skyquilt::storage
