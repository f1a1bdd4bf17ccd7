#include "api/tiles/map_window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "api/tiles/tiles.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"

namespace skyquilt::api {
namespace {

// The tiles of one zoom as one picture, decoded as they are reached.
class ZoomPicture {
 public:
  ZoomPicture(const storage::Tileset& tileset, int zoom)
      : reader_(*tileset.reader), zoom_(zoom), side_px_(TileSizePx(tileset)) {}

  int side_px() const { return side_px_; }

  // Tiles above this pixel row are needed no more.
  void ForgetAbove(std::int64_t row) {
    const std::int64_t first = FloorDiv(row);
    while (!tiles_.empty() && tiles_.begin()->first.first < first) tiles_.erase(tiles_.begin());
    last_ = nullptr;
  }

  // Absent: nothing there.
  Result<const std::uint8_t*> At(std::int64_t column, std::int64_t row) {
    const std::int64_t x = FloorDiv(column);
    const std::int64_t y = FloorDiv(row);
    if (x != last_x_ || y != last_y_ || last_ == nullptr) {
      SKYQUILT_TRY_ASSIGN(const image::RgbaImage* const tile, TileAt(x, y));
      last_x_ = x;
      last_y_ = y;
      last_ = tile;
    }
    if (last_->rgba.empty()) return static_cast<const std::uint8_t*>(nullptr);
    const auto inside_x = static_cast<std::size_t>(column - x * side_px_);
    const auto inside_y = static_cast<std::size_t>(row - y * side_px_);
    return last_->rgba.data() + (inside_y * static_cast<std::size_t>(side_px_) + inside_x) * 4;
  }

 private:
  std::int64_t FloorDiv(std::int64_t pixel) const {
    return pixel >= 0 ? pixel / side_px_ : -((-pixel + side_px_ - 1) / side_px_);
  }

  Result<const image::RgbaImage*> TileAt(std::int64_t x, std::int64_t y) {
    const auto [found, is_new] = tiles_.try_emplace({y, x});
    if (!is_new) return &found->second;
    const Result<geo::TileId> id = geo::TileId::Make(zoom_, x, y);
    if (!id) return &found->second;  // outside the world
    SKYQUILT_TRY_ASSIGN(std::optional<storage::FoundTile> stored, reader_.Find(*id));
    if (!stored) return &found->second;
    SKYQUILT_TRY_ASSIGN(const std::string bytes, reader_.Load(*std::move(stored)));
    SKYQUILT_TRY_ASSIGN(image::RgbaImage pixels, image::DecodePicture(bytes));
    if (pixels.width_px != side_px_ || pixels.height_px != side_px_) {
      return Error{ErrorCode::kCorrupt, "A stored tile has another size than its map says.", ""};
    }
    found->second = std::move(pixels);
    return &found->second;
  }

  storage::MapTiles& reader_;
  int zoom_;
  int side_px_;
  std::map<std::pair<std::int64_t, std::int64_t>, image::RgbaImage>
      tiles_;  // by row, then column; empty: no tile
  std::int64_t last_x_ = 0;
  std::int64_t last_y_ = 0;
  const image::RgbaImage* last_ = nullptr;
};

// The coarsest zoom that is not coarser than the window, or the finest there is.
int ZoomFor(const storage::Tileset& tileset, double pixel_m) {
  const storage::Revision& revision = tileset.revision;
  int zoom = revision.min_zoom;
  constexpr double kSlack = 1.0 + 1e-6;
  while (zoom < revision.max_zoom && geo::PixelSizeInMercM(zoom, TileSizePx(tileset)) > pixel_m * kSlack)
    ++zoom;
  return zoom;
}

// Where a pixel centre lies among the picture's pixel centres; what is as good as on one is on it.
struct Place {
  std::int64_t first = 0;
  double fraction = 0.0;
};

Place PlaceOf(double position) {
  constexpr double kOnCentre = 1e-3;
  const double nearest = std::round(position);
  if (std::abs(position - nearest) < kOnCentre) return {static_cast<std::int64_t>(nearest), 0.0};
  const double first = std::floor(position);
  return {static_cast<std::int64_t>(first), position - first};
}

Result<void> Blend(ZoomPicture& picture, const Place& x, const Place& y, std::uint8_t* out) {
  std::array<double, 4> sum{};
  for (int corner = 0; corner < 4; ++corner) {
    const bool is_right = (corner & 1) != 0;
    const bool is_below = (corner & 2) != 0;
    const double weight =
        (is_right ? x.fraction : 1.0 - x.fraction) * (is_below ? y.fraction : 1.0 - y.fraction);
    if (weight == 0.0) continue;
    SKYQUILT_TRY_ASSIGN(const std::uint8_t* const pixel, picture.At(x.first + is_right, y.first + is_below));
    if (pixel == nullptr) continue;
    const double alpha = weight * pixel[3];
    for (std::size_t c = 0; c < 3; ++c) sum[c] += alpha * pixel[c];
    sum[3] += alpha;
  }
  if (sum[3] <= 0.0) return {};
  for (std::size_t c = 0; c < 3; ++c) out[c] = static_cast<std::uint8_t>(std::lround(sum[c] / sum[3]));
  out[3] = static_cast<std::uint8_t>(std::lround(std::min(255.0, sum[3])));
  return {};
}

}  // namespace

Result<image::RgbaImage> RenderWindow(const storage::Tileset& tileset, const MapWindow& window) {
  const int zoom = ZoomFor(tileset, window.pixel_m);
  ZoomPicture picture(tileset, zoom);
  const double source_pixel_m = geo::PixelSizeInMercM(zoom, picture.side_px());
  image::RgbaImage out = image::RgbaImage::Transparent(window.width_px, window.height_px);
  std::vector<Place> columns;
  columns.reserve(static_cast<std::size_t>(out.width_px));
  for (int i = 0; i < out.width_px; ++i) {
    columns.push_back(PlaceOf((window.x_in_merc(i) + geo::kMercHalfWidthM) / source_pixel_m - 0.5));
  }
  std::uint8_t* pixel = out.rgba.data();
  for (int row = 0; row < out.height_px; ++row) {
    const Place y = PlaceOf((geo::kMercHalfWidthM - window.y_in_merc(row)) / source_pixel_m - 0.5);
    picture.ForgetAbove(y.first);
    for (const Place& x : columns) {
      SKYQUILT_TRY(Blend(picture, x, y, pixel));
      pixel += 4;
    }
  }
  return out;
}

}  // namespace skyquilt::api
