// TileFacts: what the addresses of a map's tiles depend on beside its row in the catalogue: how large stored
// tiles are and of which format, and its bands. Of lists of many maps: each tileset is opened once and what
// it says is kept (api/common/per_revision.h). Memory: some 200 bytes for each map that is kept. Any thread.
// Errors: those of TilesetCache.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/caches/tileset_cache.h"
#include "storage/catalogue/catalogue.h"

namespace skyquilt::api {

struct Service;

struct TileFacts {
  int side_px = 256;
  bool is_webp = false;            // throughout; else JPEG within and WebP or PNG at the edge
  std::vector<std::string> bands;  // as api/tiles/index_values.h has them at hand
};
TileFacts FactsOf(Service& service, const storage::Tileset& tileset);

// Of a list's map, looked up once (Service::tile_facts).
Result<TileFacts> FactsOf(Service& service, const storage::ShownFlight& map);

}  // namespace skyquilt::api
