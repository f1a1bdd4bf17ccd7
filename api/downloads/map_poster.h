// DrawMapPoster: the whole map as a WebP of about a hundred kilobytes, from the tiles, exactly as far as the
// map's bounds reach and in Web Mercator: laid on these bounds it lies where the tiles will. What a page
// shows while the library that draws tiles is on its way. Memory: the picture and a row of tiles. Any thread.
// Errors: kCorrupt, kIo.
#pragma once

#include <string>

#include "storage/caches/tileset_cache.h"

namespace skyquilt::api {

inline constexpr int kPosterSizePx = 1024;  // its longer side; a smaller map is not enlarged

Result<std::string> DrawMapPoster(const storage::Tileset& tileset);

}  // namespace skyquilt::api
