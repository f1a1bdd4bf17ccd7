#include "api/tiles/tile_facts.h"

#include "api/indices/index_values.h"
#include "api/tiles/tiles.h"
#include "core/base/try.h"

namespace skyquilt::api {

TileFacts FactsOf(Service& service, const storage::Tileset& tileset) {
  return {TileSizePx(tileset), storage::EncodingOf(tileset.reader->metadata()) == image::TileEncoding::kWebp,
          BandsAtHand(service, tileset)};
}

Result<TileFacts> TileFactsMemory::Of(Service& service, const storage::ShownFlight& map) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = kept_.find(map.flight_id);
    if (found != kept_.end() && found->second.revision == map.revision.revision) return found->second.facts;
  }
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset,
                      service.tilesets.Get(map.flight_id));
  const TileFacts facts = FactsOf(service, *tileset);
  const std::lock_guard lock(mutex_);
  if (kept_.size() >= kMaxKept) kept_.erase(kept_.begin());
  kept_[map.flight_id] = {tileset->revision.revision, facts};
  return facts;
}

}  // namespace skyquilt::api
