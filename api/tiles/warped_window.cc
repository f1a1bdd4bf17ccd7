#include "api/tiles/warped_window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "api/tiles/zoom_picture.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

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

}  // namespace

Result<image::RgbaImage> RenderWarpedWindow(const storage::Tileset& tileset, int zoom,
                                            const MapWindow& window) {
  ZoomPicture picture(tileset, zoom, kMaxWarpedTilesBytes);
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

}  // namespace skyquilt::api
