#include "api/tiles/tile_facts.h"

#include "api/tiles/index_values.h"
#include "api/tiles/tiles.h"
#include "core/base/try.h"

namespace skyquilt::api {

TileFacts FactsOf(Service& service, const storage::Tileset& tileset) {
  return {TileSizePx(tileset), storage::EncodingOf(tileset.reader->metadata()) == image::TileEncoding::kWebp,
          BandsAtHand(service.bands, tileset)};
}

Result<TileFacts> FactsOf(Service& service, const storage::ShownFlight& map) {
  return service.tile_facts.Of(map.flight_id, map.revision.revision, [&]() -> Result<TileFacts> {
    SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset,
                        service.tilesets.Get(map.flight_id));
    return FactsOf(service, *tileset);
  });
}

}  // namespace skyquilt::api
