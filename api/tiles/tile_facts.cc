#include "api/tiles/tile_facts.h"

#include "api/tiles/tiles.h"
#include "core/base/try.h"

namespace skyquilt::api {

TileFacts FactsOf(const storage::Tileset& tileset) {
  const auto& metadata = tileset.reader->metadata();
  const auto format = metadata.find("format");
  return {TileSizePx(tileset), format != metadata.end() && format->second == "webp"};
}

Result<TileFacts> TileFactsMemory::Of(storage::TilesetCache& tilesets, const storage::ShownFlight& map) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = kept_.find(map.flight_id);
    if (found != kept_.end() && found->second.revision == map.revision.revision) return found->second.facts;
  }
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset, tilesets.Get(map.flight_id));
  const TileFacts facts = FactsOf(*tileset);
  const std::lock_guard lock(mutex_);
  if (kept_.size() >= kMaxKept) kept_.erase(kept_.begin());
  kept_[map.flight_id] = {tileset->revision.revision, facts};
  return facts;
}

}  // namespace skyquilt::api
