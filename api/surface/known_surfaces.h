// KnownSurfaces: which heights maps have beside them, looked up once for each revision, since that never
// changes: dsm, what the photos show, and dtm, the ground below. Memory: some 100 bytes for each of the last
// kMaxKnown maps. Any thread. Errors: those of looking.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/base/result.h"
#include "storage/blobs/blob_store.h"

namespace skyquilt::api {

enum class Surface : std::uint8_t { kPhotos, kGround };

class KnownSurfaces {
 public:
  static constexpr std::size_t kMaxKnown = 50'000;

  Result<std::vector<Surface>> Of(storage::BlobStore& blobs, const std::string& flight_id,
                                  std::int64_t revision);

 private:
  struct Known {
    std::int64_t revision = 0;
    std::vector<Surface> surfaces;
  };
  std::mutex mutex_;
  std::unordered_map<std::string, Known> known_;  // by flight
};

}  // namespace skyquilt::api
