// Tiles cut from larger ones: a map of tiles with 512 or 1024 pixels also serves programs that know of 256
// alone. A tile of 256 pixels is a quarter of one of 512 a zoom before. Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "core/image/picture_format.h"

namespace skyquilt::api {

// The side that programs take for granted.
inline constexpr int kUsualTilePx = 256;

// How many zooms tiles of this side lie deeper than the stored ones that they are cut from; 0: they are
// those. Absent: they cannot be cut from them.
std::optional<int> CutDepth(int side_px, int stored_side_px);

// "512" and its kin: the sides that tiles may have. Absent: any other text.
std::optional<int> ParseTileSide(std::string_view text);

struct TileCut {
  geo::TileId stored;  // the tile that it is a part of
  int left_px = 0;
  int top_px = 0;
  int side_px = 0;
};
// Precondition: the tile's zoom is `depth` or more.
TileCut CutOf(const geo::TileId& tile, int depth, int stored_side_px);

// Empty: nothing can be seen of the tile. JPEG from JPEG is copied without loss. Errors: kCorrupt, kTooLarge.
Result<std::string> CutTile(std::string_view stored_bytes, const TileCut& cut, image::PictureFormat to);

}  // namespace skyquilt::api
