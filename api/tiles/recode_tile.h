// Encoded tiles in another format or of another side than they are stored in: a map of tiles with 512 or 1024
// pixels also serves programs that know of 256 alone (a tile of 256 pixels is a quarter of one of 512 a zoom
// before). Pure. Errors: kCorrupt (bytes that do not decode), kTooLarge (a side of more than
// image::kMaxPictureSidePx).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/geo/tile_id.h"
#include "core/image/picture_format.h"
#include "core/image/rgba_image.h"

namespace skyquilt::api {

// Straight alpha; JPEG is laid on white.
std::string EncodeTile(image::RgbaImage tile, image::PictureFormat to);
Result<std::string> TranscodeTile(std::string_view bytes, image::PictureFormat to);
// An empty tile of minimal size.
std::string TransparentPng(int side_px);

// The side that programs take for granted.
inline constexpr int kUsualTilePx = 256;

// How many zooms tiles of this side lie deeper than the stored ones that they are cut from; 0: they are
// those. Absent: they cannot be cut from them.
std::optional<int> CutDepth(int side_px, int stored_side_px);

struct TileCut {
  geo::TileId stored;  // the tile that it is a part of
  int left_px = 0;
  int top_px = 0;
  int side_px = 0;
};
// Precondition: the tile's zoom is `depth` or more.
TileCut CutOf(const geo::TileId& tile, int depth, int stored_side_px);

// Empty: nothing can be seen of the tile. JPEG from JPEG is copied without loss.
Result<std::string> CutTile(std::string_view stored_bytes, const TileCut& cut, image::PictureFormat to);

}  // namespace skyquilt::api
