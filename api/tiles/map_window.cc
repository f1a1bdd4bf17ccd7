#include "api/tiles/map_window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/tiles/tiles.h"
#include "core/base/try.h"
#include "core/geo/bounds.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"

namespace skyquilt::api {
namespace {

// Where something lies among the middles of pixels; what is as good as on one is on it.
struct PixelPlace {
  std::int64_t first = 0;
  double fraction = 0.0;
};

// The tiles of one zoom of a map as one picture, decoded as they are reached, and its pixels between their
// middles. Memory: the decoded tiles, until they are forgotten or beyond the budget.
class ZoomPicture {
 public:
  // Beyond the budget, which always has room for four tiles, all but the last one reached are forgotten.
  ZoomPicture(const storage::Tileset& tileset, int zoom, const TileBudget& budget);

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
  bool is_across_antimeridian_;  // then its tiles go on at the other end of the world
  std::size_t budget_bytes_;
  std::int64_t left_px_;  // that may still be decoded
  std::optional<geo::Bounds2> reach_px_;
  // By row, then column; empty: no tile.
  std::map<std::pair<std::int64_t, std::int64_t>, image::RgbaImage> tiles_ = {};
  std::size_t bytes_ = 0;
  std::int64_t last_x_ = 0, last_y_ = 0;
  const image::RgbaImage* last_ = nullptr;
};

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

PixelPlace PixelPlaceOf(double position) {
  constexpr double kOnCentre = 1e-3;
  const double nearest = std::round(position);
  if (std::abs(position - nearest) < kOnCentre) return {static_cast<std::int64_t>(nearest), 0.0};
  const double first = std::floor(position);
  return {static_cast<std::int64_t>(first), position - first};
}

ZoomPicture::ZoomPicture(const storage::Tileset& tileset, int zoom, const TileBudget& budget)
    : reader_(*tileset.reader),
      zoom_(zoom),
      side_px_(TileSizePx(tileset)),
      is_across_antimeridian_(tileset.revision.bounds.east_deg > 180.0),
      budget_bytes_(budget.kept_bytes),
      left_px_(budget.decoded_px),
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
  const std::int64_t around = std::int64_t{1} << zoom_;
  const std::int64_t column = is_across_antimeridian_ ? (x % around + around) % around : x;
  const Result<geo::TileId> id = geo::TileId::Make(zoom_, column, y);
  std::optional<storage::FoundTile> stored;  // none outside the world
  if (id) {
    SKYQUILT_TRY_ASSIGN(stored, reader_.Find(*id));
  }
  if (stored) {
    left_px_ -= std::int64_t{side_px_} * side_px_;
    if (left_px_ < 0)
      return Error{
          ErrorCode::kTooLarge,
          "The map has no tiles coarse enough for a picture of so much of it. Ask for a smaller part, "
          "or for fewer pixels."};
    SKYQUILT_TRY_ASSIGN(const std::string bytes, reader_.Load(*std::move(stored)));
    SKYQUILT_TRY_ASSIGN(pixels, image::DecodePicture(bytes));
    if (pixels.width_px != side_px_ || pixels.height_px != side_px_)
      return Error{ErrorCode::kCorrupt, "A stored tile has another size than its map says."};
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

constexpr std::size_t kMaxWarpedTilesBytes = std::size_t{64} << 20;

constexpr int kSquarePx = 32;
constexpr int kSquaresInBlock =
    8;  // of squares that are read one after the other, so that tiles stay decoded
constexpr double kMaxOffPx = 0.02;

// Pixels of a window: from first to behind last.
struct Square {
  int left = 0, top = 0, right = 0, bottom = 0;
  int width() const { return right - left; }
  int height() const { return bottom - top; }
};

// Where the middles of a window's pixels lie in the picture of a zoom, in pixels from its first middle.
class WarpedPlaces {
 public:
  WarpedPlaces(const ZoomPicture& picture, int zoom, const MapWindow& window)
      : window_(window),
        pixel_m_(geo::PixelSizeInMercM(zoom, picture.side_px())),
        reach_px_(picture.reach_px()) {}

  // Of a square, row by row; not a number where it shows nothing.
  const std::vector<Eigen::Vector2d>& Of(const Square& square) {
    whole_ = square;
    places_.assign(static_cast<std::size_t>(square.width()) * static_cast<std::size_t>(square.height()),
                   Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
    Fill(square);
    return places_;
  }

 private:
  Eigen::Vector2d Exact(double column, double row) const {
    const Eigen::Vector2d merc = window_.merc_of(column, row);
    return {(merc.x() + geo::kMercHalfWidthM) / pixel_m_ - 0.5,
            (geo::kMercHalfWidthM - merc.y()) / pixel_m_ - 0.5};
  }

  Eigen::Vector2d& Place(int column, int row) {
    return places_[static_cast<std::size_t>(row - whole_.top) * static_cast<std::size_t>(whole_.width()) +
                   static_cast<std::size_t>(column - whole_.left)];
  }

  void Fill(const Square& square) {
    if (square.width() == 1 && square.height() == 1) {
      Place(square.left, square.top) = Exact(square.left + 0.5, square.top + 0.5);
      return;
    }
    // Three by three places of the square's outline, corners, sides and middle.
    std::array<Eigen::Vector2d, 9> known;
    for (std::size_t i = 0; i < known.size(); ++i) {
      const std::size_t along = i % 3, down = i / 3;
      known[i] = Exact(square.left + 0.5 * static_cast<double>(along) * square.width(),
                       square.top + 0.5 * static_cast<double>(down) * square.height());
    }
    const auto is_place = [](const Eigen::Vector2d& place) { return place.allFinite(); };
    if (std::none_of(known.begin(), known.end(), is_place)) return;
    if (std::all_of(known.begin(), known.end(), is_place)) {
      if (IsBesideMap(known)) return;
      if (IsBilinear(known)) {
        Interpolate(square, known);
        return;
      }
    }
    const int middle_x = square.left + (square.width() + 1) / 2,
              middle_y = square.top + (square.height() + 1) / 2;
    for (const Square& part : {Square{square.left, square.top, middle_x, middle_y},
                               Square{middle_x, square.top, square.right, middle_y},
                               Square{square.left, middle_y, middle_x, square.bottom},
                               Square{middle_x, middle_y, square.right, square.bottom}}) {
      if (part.width() > 0 && part.height() > 0) Fill(part);
    }
  }

  // By as much as the square is wide, so that no bend of it comes back to the map.
  bool IsBesideMap(const std::array<Eigen::Vector2d, 9>& known) const {
    if (!reach_px_) return false;
    geo::Bounds2 around;
    for (const Eigen::Vector2d& place : known) around.Include(place);
    const double room = around.Width() + around.Height();
    around.min.array() -= room;
    around.max.array() += room;
    return !around.Intersects(*reach_px_);
  }

  static bool IsBilinear(const std::array<Eigen::Vector2d, 9>& known) {
    const auto is_off = [&](std::size_t between, std::initializer_list<std::size_t> corners) {
      Eigen::Vector2d mean = Eigen::Vector2d::Zero();
      for (const std::size_t corner : corners) mean += known[corner] / static_cast<double>(corners.size());
      return !((known[between] - mean).cwiseAbs().maxCoeff() <= kMaxOffPx);
    };
    return !is_off(1, {0, 2}) && !is_off(3, {0, 6}) && !is_off(5, {2, 8}) && !is_off(7, {6, 8}) &&
           !is_off(4, {0, 2, 6, 8});
  }

  void Interpolate(const Square& square, const std::array<Eigen::Vector2d, 9>& known) {
    for (int row = square.top; row < square.bottom; ++row) {
      const double down = (row - square.top + 0.5) / square.height();
      const Eigen::Vector2d left = known[0] + down * (known[6] - known[0]);
      const Eigen::Vector2d right = known[2] + down * (known[8] - known[2]);
      for (int column = square.left; column < square.right; ++column) {
        const double along = (column - square.left + 0.5) / square.width();
        Place(column, row) = left + along * (right - left);
      }
    }
  }

  const MapWindow& window_;
  double pixel_m_;
  std::optional<geo::Bounds2> reach_px_;
  Square whole_;
  std::vector<Eigen::Vector2d> places_;
};

Result<void> RenderSquare(ZoomPicture& picture, WarpedPlaces& places, const Square& square,
                          image::RgbaImage& out) {
  const std::vector<Eigen::Vector2d>& found = places.Of(square);
  auto place = found.begin();
  for (int row = square.top; row < square.bottom; ++row) {
    for (int column = square.left; column < square.right; ++column, ++place) {
      if (!place->allFinite()) continue;
      SKYQUILT_TRY(picture.Blend(PixelPlaceOf(place->x()), PixelPlaceOf(place->y()), out.Pixel(column, row)));
    }
  }
  return {};
}

// A window in another coordinate system, whose rows and columns do not run along the tiles. Where its pixels
// lie is computed at the corners, sides and middles of squares of pixels and between them bilinearly, unless
// that is off by more than a fiftieth of a pixel of the map: then the square is divided. Precondition: the
// window has merc_of. `zoom`: the one that is read.
Result<image::RgbaImage> RenderWarpedWindow(const storage::Tileset& tileset, int zoom,
                                            const MapWindow& window, TileBudget budget) {
  budget.kept_bytes = std::min(budget.kept_bytes, kMaxWarpedTilesBytes);
  ZoomPicture picture(tileset, zoom, budget);
  WarpedPlaces places(picture, zoom, window);
  image::RgbaImage out = image::RgbaImage::Transparent(window.width_px, window.height_px);
  constexpr int kBlockPx = kSquarePx * kSquaresInBlock;
  for (int block_y = 0; block_y < out.height_px; block_y += kBlockPx) {
    for (int block_x = 0; block_x < out.width_px; block_x += kBlockPx) {
      const int bottom = std::min(block_y + kBlockPx, out.height_px);
      const int right = std::min(block_x + kBlockPx, out.width_px);
      for (int y = block_y; y < bottom; y += kSquarePx) {
        for (int x = block_x; x < right; x += kSquarePx) {
          const Square square{x, y, std::min(x + kSquarePx, right), std::min(y + kSquarePx, bottom)};
          SKYQUILT_TRY(RenderSquare(picture, places, square, out));
        }
      }
    }
  }
  return out;
}

// The coarsest zoom that is not coarser than the window, or the finest there is.
int ZoomFor(const storage::Tileset& tileset, double pixel_m) {
  const storage::Revision& revision = tileset.revision;
  int zoom = revision.min_zoom;
  constexpr double kSlack = 1.0 + 1e-6;
  while (zoom < revision.max_zoom && geo::PixelSizeInMercM(zoom, TileSizePx(tileset)) > pixel_m * kSlack)
    ++zoom;
  return zoom;
}

// The middle of the pixel of a grid that a coordinate lies in.
double MiddleOfPixel(double merc_m, double pixel_m) { return (std::floor(merc_m / pixel_m) + 0.5) * pixel_m; }

}  // namespace

MapWindow WindowOfTile(const geo::TileId& tile, int side_px) {
  const geo::Bounds2 bounds = tile.BoundsInMerc();
  const double pixel_m = bounds.Width() / side_px;
  return {side_px, side_px,
          [west = bounds.min.x(), pixel_m](int column) { return west + (column + 0.5) * pixel_m; },
          [north = bounds.max.y(), pixel_m](int row) { return north - (row + 0.5) * pixel_m; }, pixel_m};
}

MapWindow WindowOfFinestPixel(const storage::Tileset& tileset, const Eigen::Vector2d& merc) {
  MapWindow window;
  window.width_px = window.height_px = 1;
  window.pixel_m = geo::PixelSizeInMercM(tileset.revision.max_zoom, TileSizePx(tileset));
  const double x = MiddleOfPixel(merc.x() + geo::kMercHalfWidthM, window.pixel_m) - geo::kMercHalfWidthM;
  const double y = geo::kMercHalfWidthM - MiddleOfPixel(geo::kMercHalfWidthM - merc.y(), window.pixel_m);
  window.x_in_merc = [x](int) { return x; };
  window.y_in_merc = [y](int) { return y; };
  return window;
}

Result<image::RgbaImage> RenderWindow(const storage::Tileset& tileset, const MapWindow& window,
                                      const TileBudget& budget) {
  const int zoom = ZoomFor(tileset, window.pixel_m);
  if (window.merc_of) return RenderWarpedWindow(tileset, zoom, window, budget);
  ZoomPicture picture(tileset, zoom, budget);
  const double source_pixel_m = geo::PixelSizeInMercM(zoom, picture.side_px());
  image::RgbaImage out = image::RgbaImage::Transparent(window.width_px, window.height_px);
  std::vector<PixelPlace> columns;
  columns.reserve(static_cast<std::size_t>(out.width_px));
  for (int i = 0; i < out.width_px; ++i) {
    columns.push_back(PixelPlaceOf((window.x_in_merc(i) + geo::kMercHalfWidthM) / source_pixel_m - 0.5));
  }
  std::uint8_t* pixel = out.rgba.data();
  for (int row = 0; row < out.height_px; ++row) {
    const PixelPlace y = PixelPlaceOf((geo::kMercHalfWidthM - window.y_in_merc(row)) / source_pixel_m - 0.5);
    picture.ForgetAbove(y.first);
    for (const PixelPlace& x : columns) {
      SKYQUILT_TRY(picture.Blend(x, y, pixel));
      pixel += 4;
    }
  }
  return out;
}

}  // namespace skyquilt::api
