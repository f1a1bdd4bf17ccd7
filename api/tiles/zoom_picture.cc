#include "api/tiles/zoom_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "api/tiles/tiles.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"

namespace skyquilt::api {
namespace {

constexpr std::size_t kBesideTileBytes = 256;  // its place in the map, about
constexpr std::size_t kMinTiles = 4;           // that a pixel may be between

// A tile more on every side, for bounds that are told to a few digits.
std::optional<geo::Bounds2> ReachOf(const storage::Revision& revision, int zoom, int side_px) {
  const geo::LatLonBounds& bounds = revision.bounds;
  const bool is_told = bounds.west_deg < bounds.east_deg && bounds.south_deg < bounds.north_deg;
  // Beyond the antimeridian a map's tiles go on at the other end of the world.
  if (!is_told || bounds.east_deg > 180.0 || bounds.west_deg < -180.0) return std::nullopt;
  const geo::Bounds2 merc = geo::MercFromLatLonBounds(bounds);
  const double pixel_m = geo::PixelSizeInMercM(zoom, side_px);
  geo::Bounds2 reach;
  reach.min = {(merc.min.x() + geo::kMercHalfWidthM) / pixel_m - side_px,
               (geo::kMercHalfWidthM - merc.max.y()) / pixel_m - side_px};
  reach.max = {(merc.max.x() + geo::kMercHalfWidthM) / pixel_m + side_px,
               (geo::kMercHalfWidthM - merc.min.y()) / pixel_m + side_px};
  return reach;
}

}  // namespace

PixelPlace PixelPlaceOf(double position) {
  constexpr double kOnCentre = 1e-3;
  const double nearest = std::round(position);
  if (std::abs(position - nearest) < kOnCentre) return {static_cast<std::int64_t>(nearest), 0.0};
  const double first = std::floor(position);
  return {static_cast<std::int64_t>(first), position - first};
}

ZoomPicture::ZoomPicture(const storage::Tileset& tileset, int zoom, std::size_t budget_bytes)
    : reader_(*tileset.reader),
      zoom_(zoom),
      side_px_(TileSizePx(tileset)),
      budget_bytes_(budget_bytes),
      reach_px_(ReachOf(tileset.revision, zoom, side_px_)) {
  const auto side = static_cast<std::size_t>(side_px_);
  budget_bytes_ = std::max(budget_bytes_, kMinTiles * (side * side * 4 + kBesideTileBytes));
}

void ZoomPicture::ForgetAbove(std::int64_t row) {
  const std::int64_t first = TileOf(row);
  while (!tiles_.empty() && tiles_.begin()->first.first < first) {
    bytes_ -= tiles_.begin()->second.rgba.size() + kBesideTileBytes;
    tiles_.erase(tiles_.begin());
  }
  last_ = nullptr;
}

Result<void> ZoomPicture::Blend(const PixelPlace& x, const PixelPlace& y, std::uint8_t* out) {
  if (reach_px_) {
    const auto column = static_cast<double>(x.first), row = static_cast<double>(y.first);
    if (!reach_px_->Contains({column, row})) return {};
  }
  std::array<double, 4> sum{};
  for (int corner = 0; corner < 4; ++corner) {
    const bool is_right = (corner & 1) != 0;
    const bool is_below = (corner & 2) != 0;
    const double weight =
        (is_right ? x.fraction : 1.0 - x.fraction) * (is_below ? y.fraction : 1.0 - y.fraction);
    if (weight == 0.0) continue;
    SKYQUILT_TRY_ASSIGN(const std::uint8_t* const pixel, At(x.first + is_right, y.first + is_below));
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

std::int64_t ZoomPicture::TileOf(std::int64_t pixel) const {
  return pixel >= 0 ? pixel / side_px_ : -((-pixel + side_px_ - 1) / side_px_);
}

Result<const std::uint8_t*> ZoomPicture::At(std::int64_t column, std::int64_t row) {
  const std::int64_t x = TileOf(column);
  const std::int64_t y = TileOf(row);
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

Result<const image::RgbaImage*> ZoomPicture::TileAt(std::int64_t x, std::int64_t y) {
  const auto found = tiles_.find({y, x});
  if (found != tiles_.end()) return &found->second;
  image::RgbaImage pixels;
  const Result<geo::TileId> id = geo::TileId::Make(zoom_, x, y);
  std::optional<storage::FoundTile> stored;  // none outside the world
  if (id) {
    SKYQUILT_TRY_ASSIGN(stored, reader_.Find(*id));
  }
  if (stored) {
    SKYQUILT_TRY_ASSIGN(const std::string bytes, reader_.Load(*std::move(stored)));
    SKYQUILT_TRY_ASSIGN(pixels, image::DecodePicture(bytes));
    if (pixels.width_px != side_px_ || pixels.height_px != side_px_)
      return Error{ErrorCode::kCorrupt, "A stored tile has another size than its map says.", ""};
  }
  const std::size_t cost = pixels.rgba.size() + kBesideTileBytes;
  if (bytes_ > budget_bytes_ || cost > budget_bytes_ - bytes_) {
    tiles_.clear();
    bytes_ = 0;
    last_ = nullptr;
  }
  bytes_ += cost;
  return &tiles_.try_emplace({y, x}, std::move(pixels)).first->second;
}

}  // namespace skyquilt::api
