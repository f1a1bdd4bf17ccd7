// TileFacts: what the addresses of a map's tiles depend on beside its row in the catalogue: how large stored
// tiles are and of which format, and its bands. Of lists of many maps: each tileset is opened once and what
// it says is kept, since a revision never changes. Memory: some 200 bytes for each of the last kMaxKept maps.
// Any thread. Errors: those of TilesetCache.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/base/result.h"
#include "storage/catalogue/catalogue.h"
#include "storage/tilesets/tileset_cache.h"

namespace skyquilt::api {

struct Service;

struct TileFacts {
  int side_px = 256;
  bool is_webp = false;            // throughout; else JPEG within and WebP or PNG at the edge
  std::vector<std::string> bands;  // as api/indices/index_values.h has them at hand
};
TileFacts FactsOf(Service& service, const storage::Tileset& tileset);

class TileFactsMemory {
 public:
  static constexpr std::size_t kMaxKept = 50'000;

  Result<TileFacts> Of(Service& service, const storage::ShownFlight& map);

 private:
  struct Kept {
    std::int64_t revision = 0;
    TileFacts facts;
  };
  std::mutex mutex_;
  std::unordered_map<std::string, Kept> kept_;
};

}  // namespace skyquilt::api
