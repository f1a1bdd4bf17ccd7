#include "api/tiles/recode_tile.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/image/picture_codec.h"

namespace skyquilt::api {

std::string EncodeTile(image::RgbaImage tile, image::PictureFormat to) {
  const std::vector<std::uint8_t> bytes = image::EncodePicture(std::move(tile), to);
  return {bytes.begin(), bytes.end()};
}

Result<std::string> TranscodeTile(std::string_view bytes, image::PictureFormat to) {
  SKYQUILT_TRY_ASSIGN(image::RgbaImage tile, image::DecodePicture(bytes));
  return EncodeTile(std::move(tile), to);
}

std::string TransparentPng(int side_px) {
  const std::vector<std::uint8_t> bytes =
      image::EncodePlainPng(image::RgbaImage::Transparent(side_px, side_px));
  return {bytes.begin(), bytes.end()};
}

std::optional<int> CutDepth(int side_px, int stored_side_px) {
  int depth = 0;
  while (side_px < stored_side_px) {
    side_px *= 2;
    ++depth;
  }
  return side_px == stored_side_px ? std::optional(depth) : std::nullopt;
}

TileCut CutOf(const geo::TileId& tile, int depth, int stored_side_px) {
  TileCut cut;
  const Result<geo::TileId> stored =
      geo::TileId::Make(tile.z() - depth, tile.x() >> depth, tile.y() >> depth);
  SKYQUILT_CHECK(stored.ok(), "a tile above the world");
  cut.stored = *stored;
  cut.side_px = stored_side_px >> depth;
  const std::uint32_t last = (1U << depth) - 1U;
  cut.left_px = static_cast<int>(tile.x() & last) * cut.side_px;
  cut.top_px = static_cast<int>(tile.y() & last) * cut.side_px;
  return cut;
}

Result<std::string> CutTile(std::string_view stored_bytes, const TileCut& cut, image::PictureFormat to) {
  if (to == image::PictureFormat::kJpeg && image::PictureFormatOf(stored_bytes) == to) {
    SKYQUILT_TRY_ASSIGN(const std::vector<std::uint8_t> bytes,
                        image::CutJpeg(stored_bytes, cut.left_px, cut.top_px, cut.side_px));
    return std::string(bytes.begin(), bytes.end());
  }
  SKYQUILT_TRY_ASSIGN(const image::RgbaImage stored, image::DecodePicture(stored_bytes));
  if (stored.width_px < cut.left_px + cut.side_px || stored.height_px < cut.top_px + cut.side_px) {
    return Error{ErrorCode::kCorrupt, "A stored tile has another size than its map says."};
  }
  image::RgbaImage piece = image::RgbaImage::Transparent(cut.side_px, cut.side_px);
  bool is_seen = false;
  for (int row = 0; row < cut.side_px; ++row) {
    const std::uint8_t* const first = stored.Pixel(cut.left_px, cut.top_px + row);
    std::copy_n(first, std::size_t{4} * static_cast<std::size_t>(cut.side_px), piece.Pixel(0, row));
    for (int column = 0; column < cut.side_px; ++column) is_seen |= first[4 * column + 3] != 0;
  }
  return is_seen ? EncodeTile(std::move(piece), to) : std::string();
}

}  // namespace skyquilt::api
