// What answers to tile requests of every kind share: empty tiles, tiles that are made and kept, and the
// headers that say how long they hold. Any thread.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "api/service.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tiles.h"

namespace skyquilt::api {

// Not on this thread: the request is repeated where such work is done.
Response DeferTo(Work work);
// The map that a tile is of. Null: not at hand for this thread, which is to DeferTo(Work::kRead).
Result<std::shared_ptr<const storage::Tileset>> MapFor(Service& service, const Request& request,
                                                       const std::string& flight_id);
// An address that names the revision it shows never changes its bytes.
const char* CacheControl(const Request& request, const storage::Tileset& tileset);
// How long an answer holds, and its tag. 304: the client has it.
Response TaggedHead(const Request& request, const char* cache_control, std::string etag);
// Where the map has nothing: as the parameter "empty" says, or else as the address has it. Errors:
// kInvalidArgument (the parameter), kNotFound (where that is the answer).
Result<Response> BlankAnswer(const Request& request, EmptyTile otherwise, int side_px,
                             const char* cache_control);

// From those that were made before, or made here if this is the place. Null: it is not.
Result<std::shared_ptr<const storage::MadeTile>> Made(Service& service, const Request& request,
                                                      const storage::MadeTileKey& key,
                                                      const std::function<Result<std::string>()>& make);
// The same, answered: deferred where this is not the place; where nothing can be seen of it (no bytes), as
// BlankAnswer has it. `variant`: what kind of made tile it is, for its tag.
Result<Response> AnswerMade(Service& service, const Request& request, const storage::Tileset& tileset,
                            const storage::MadeTileKey& key, std::string_view variant,
                            const std::function<Result<std::string>()>& make,
                            EmptyTile empty = EmptyTile::kBlank, int side_px = kUsualTilePx);

}  // namespace skyquilt::api
