// ZoomPicture: the tiles of one zoom of a map as one picture, decoded as they are reached, and its pixels
// between their middles. What windows are read from. Memory: the decoded tiles, until they are forgotten or
// beyond the budget. One thread. Errors: kCorrupt, kIo, and those of reading tiles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/geo/bounds.h"
#include "core/image/rgba_image.h"
#include "storage/caches/tileset_cache.h"

namespace skyquilt::api {

// Where something lies among the middles of pixels; what is as good as on one is on it.
struct PixelPlace {
  std::int64_t first = 0;
  double fraction = 0.0;
};
PixelPlace PixelPlaceOf(double position);

class ZoomPicture {
 public:
  // Beyond the budget, which always has room for four tiles, all but the last one reached are forgotten.
  ZoomPicture(const storage::Tileset& tileset, int zoom,
              std::size_t budget_bytes = std::numeric_limits<std::size_t>::max());

  int side_px() const { return side_px_; }
  // Where tiles may be, in pixels of the picture's corners. Absent: anywhere.
  const std::optional<geo::Bounds2>& reach_px() const { return reach_px_; }

  // Tiles above this pixel row are needed no more.
  void ForgetAbove(std::int64_t row);
  // Bilinear, straight alpha. What shows nothing is left as it is.
  Result<void> Blend(const PixelPlace& x, const PixelPlace& y, std::uint8_t* out);

 private:
  std::int64_t TileOf(std::int64_t pixel) const;
  // Null: nothing there. Valid until the next call.
  Result<const std::uint8_t*> At(std::int64_t column, std::int64_t row);
  Result<const image::RgbaImage*> TileAt(std::int64_t x, std::int64_t y);

  storage::MapTiles& reader_;
  int zoom_;
  int side_px_;
  std::size_t budget_bytes_;
  std::optional<geo::Bounds2> reach_px_;
  // By row, then column; empty: no tile.
  std::map<std::pair<std::int64_t, std::int64_t>, image::RgbaImage> tiles_ = {};
  std::size_t bytes_ = 0;
  std::int64_t last_x_ = 0, last_y_ = 0;
  const image::RgbaImage* last_ = nullptr;
};

}  // namespace skyquilt::api
