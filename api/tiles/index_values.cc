#include "api/tiles/index_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "api/tiles/tiles.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"

namespace skyquilt::api {
namespace {

using storage::ColourBands;
using storage::PlacesOf;

std::size_t PixelCount(int width_px, int height_px) {
  return static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
}

template <typename Value>
IndexValues Evaluated(const indices::BandExpression& expression,
                      const std::vector<std::vector<Value>>& planes, std::vector<std::uint8_t> alphas,
                      int width_px, int height_px) {
  IndexValues made{width_px, height_px, std::vector<float>(PixelCount(width_px, height_px)),
                   std::move(alphas)};
  std::vector<const Value*> rows;
  rows.reserve(planes.size());
  for (const std::vector<Value>& plane : planes) rows.push_back(plane.data());
  expression.Evaluate(rows, made.values);
  for (std::size_t i = 0; i < made.values.size(); ++i) {
    if (std::isnan(made.values[i])) made.alphas[i] = 0;
    if (made.alphas[i] == 0) made.values[i] = std::numeric_limits<float>::quiet_NaN();
  }
  return made;
}

Result<IndexValues> ValuesOfColours(const indices::BandExpression& expression,
                                    const image::RgbaImage& picture) {
  SKYQUILT_TRY_ASSIGN(const std::vector<std::size_t> channels, PlacesOf(expression, ColourBands()));
  const std::size_t pixels = PixelCount(picture.width_px, picture.height_px);
  // Doubles, so that differences of colours that are zero on paper are those of numpy.
  std::vector<std::vector<double>> planes(channels.size(), std::vector<double>(pixels));
  for (std::size_t plane = 0; plane < channels.size(); ++plane) {
    const std::uint8_t* const channel = picture.rgba.data() + channels[plane];
    for (std::size_t i = 0; i < pixels; ++i) planes[plane][i] = channel[4 * i] / 255.0;
  }
  std::vector<std::uint8_t> alphas(pixels);
  for (std::size_t i = 0; i < pixels; ++i) alphas[i] = picture.rgba[4 * i + 3];
  return Evaluated(expression, planes, std::move(alphas), picture.width_px, picture.height_px);
}

Result<IndexValues> ValuesOfRaster(storage::BandRaster& raster, const indices::BandExpression& expression,
                                   const storage::MercGrid& grid) {
  SKYQUILT_TRY_ASSIGN(const std::vector<std::size_t> places, PlacesOf(expression, raster.bands()));
  SKYQUILT_TRY_ASSIGN(const std::vector<std::vector<float>> planes, raster.Read(grid, places));
  return Evaluated(expression, planes,
                   std::vector<std::uint8_t>(PixelCount(grid.width_px, grid.height_px), 255), grid.width_px,
                   grid.height_px);
}

// Windows in degrees have rows of different heights: each takes the nearest of as many equal ones.
IndexValues WithRowsOf(IndexValues equal, const MapWindow& window, const storage::MercGrid& grid) {
  IndexValues made = equal;
  const auto width = static_cast<std::size_t>(equal.width_px);
  for (int row = 0; row < window.height_px; ++row) {
    const double place = (grid.north_m - window.y_in_merc(row)) / grid.pixel_height_m;
    const auto from = static_cast<std::size_t>(std::clamp(static_cast<int>(place), 0, equal.height_px - 1));
    const auto to = static_cast<std::size_t>(row);
    if (from == to) continue;
    std::copy_n(equal.values.begin() + static_cast<std::ptrdiff_t>(from * width), width,
                made.values.begin() + static_cast<std::ptrdiff_t>(to * width));
    std::copy_n(equal.alphas.begin() + static_cast<std::ptrdiff_t>(from * width), width,
                made.alphas.begin() + static_cast<std::ptrdiff_t>(to * width));
  }
  return made;
}

// The equal pixels over what a window shows.
storage::MercGrid GridOver(const MapWindow& window) {
  const int columns = window.width_px, rows = window.height_px;
  const auto step = [&](double first, double last, int count) {
    return count > 1 ? std::abs(last - first) / (count - 1) : window.pixel_m;
  };
  storage::MercGrid grid;
  grid.pixel_width_m = step(window.x_in_merc(0), window.x_in_merc(columns - 1), columns);
  grid.pixel_height_m = step(window.y_in_merc(0), window.y_in_merc(rows - 1), rows);
  grid.west_m = window.x_in_merc(0) - grid.pixel_width_m / 2;
  grid.north_m = window.y_in_merc(0) + grid.pixel_height_m / 2;
  grid.width_px = columns;
  grid.height_px = rows;
  return grid;
}

// The equal pixels over a window whose rows and columns do not run along them, as fine as it. Absent: it lies
// nowhere. No larger than two times the window.
std::optional<storage::MercGrid> GridAround(const MapWindow& window) {
  constexpr int kSteps = 32;
  geo::Bounds2 around;
  for (int row = 0; row <= kSteps; ++row) {
    for (int column = 0; column <= kSteps; ++column) {
      const Eigen::Vector2d merc = window.merc_of(static_cast<double>(column) / kSteps * window.width_px,
                                                  static_cast<double>(row) / kSteps * window.height_px);
      if (merc.allFinite()) around.Include(merc);
    }
  }
  if (around.IsEmpty()) return std::nullopt;
  const double most_px = 2.0 * std::max(window.width_px, window.height_px);
  storage::MercGrid grid;
  grid.west_m = around.min.x() - window.pixel_m;
  grid.north_m = around.max.y() + window.pixel_m;
  const double width_m = around.Width() + 2 * window.pixel_m, height_m = around.Height() + 2 * window.pixel_m;
  grid.width_px = static_cast<int>(std::ceil(std::min(most_px, width_m / window.pixel_m)));
  grid.height_px = static_cast<int>(std::ceil(std::min(most_px, height_m / window.pixel_m)));
  grid.pixel_width_m = width_m / grid.width_px;
  grid.pixel_height_m = height_m / grid.height_px;
  return grid;
}

// Each pixel takes the nearest of the equal ones.
IndexValues WarpedFrom(const IndexValues& equal, const MapWindow& window, const storage::MercGrid& grid) {
  const std::size_t pixels = PixelCount(window.width_px, window.height_px);
  IndexValues made{window.width_px, window.height_px,
                   std::vector<float>(pixels, std::numeric_limits<float>::quiet_NaN()),
                   std::vector<std::uint8_t>(pixels, 0)};
  std::size_t to = 0;
  for (int row = 0; row < window.height_px; ++row) {
    for (int column = 0; column < window.width_px; ++column, ++to) {
      const Eigen::Vector2d merc = window.merc_of(column + 0.5, row + 0.5);
      const double x = std::floor((merc.x() - grid.west_m) / grid.pixel_width_m);
      const double y = std::floor((grid.north_m - merc.y()) / grid.pixel_height_m);
      if (!(x >= 0.0 && x < grid.width_px && y >= 0.0 && y < grid.height_px)) continue;
      const std::size_t from =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width_px) + static_cast<std::size_t>(x);
      made.values[to] = equal.values[from];
      made.alphas[to] = equal.alphas[from];
    }
  }
  return made;
}

// As it is stored; without an entry, transparent.
Result<image::RgbaImage> StoredPicture(const storage::Tileset& tileset, const geo::TileId& tile,
                                       int side_px) {
  SKYQUILT_TRY_ASSIGN(std::optional<storage::FoundTile> found, tileset.reader->Find(tile));
  if (!found) return image::RgbaImage::Transparent(side_px, side_px);
  SKYQUILT_TRY_ASSIGN(const std::string bytes, tileset.reader->Load(*std::move(found)));
  SKYQUILT_TRY_ASSIGN(image::RgbaImage picture, image::DecodePicture(bytes));
  if (picture.width_px != side_px || picture.height_px != side_px)
    return Error{ErrorCode::kCorrupt, "A stored tile has another size than its map says."};
  return picture;
}

}  // namespace

Result<std::vector<std::string>> BandsOf(MapBands& map_bands, const storage::Tileset& tileset) {
  SKYQUILT_TRY_ASSIGN(const auto raster, map_bands.Of(tileset));
  return raster ? raster->bands() : ColourBands();
}

Result<std::optional<geo::Bounds2>> BoundsOfBands(MapBands& map_bands, const storage::Tileset& tileset) {
  SKYQUILT_TRY_ASSIGN(const auto raster, map_bands.Of(tileset));
  return raster ? std::optional(raster->BoundsInMerc()) : std::nullopt;
}

std::vector<std::string> BandsAtHand(MapBands& map_bands, const storage::Tileset& tileset) {
  if (!map_bands.AreHere()) return ColourBands();
  const Result<std::vector<std::string>> bands = BandsOf(map_bands, tileset);
  return bands ? *bands : std::vector<std::string>();
}

Result<void> CheckBands(MapBands& map_bands, const storage::Tileset& tileset,
                        const indices::BandExpression& expression) {
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> bands, BandsOf(map_bands, tileset));
  SKYQUILT_TRY(PlacesOf(expression, bands));
  return {};
}

Result<IndexValues> ValuesOfTile(MapBands& map_bands, const storage::Tileset& tileset,
                                 const indices::BandExpression& expression, const geo::TileId& tile,
                                 int side_px) {
  SKYQUILT_TRY_ASSIGN(const auto raster, map_bands.Of(tileset));
  const MapWindow window = WindowOfTile(tile, side_px);
  if (raster) return ValuesOfRaster(*raster, expression, GridOver(window));
  SKYQUILT_TRY(PlacesOf(expression, ColourBands()));  // before anything is decoded
  const storage::Revision& map = tileset.revision;
  const bool is_stored =
      side_px == TileSizePx(tileset) && tile.z() >= map.min_zoom && tile.z() <= map.max_zoom;
  SKYQUILT_TRY_ASSIGN(const image::RgbaImage picture,
                      is_stored ? StoredPicture(tileset, tile, side_px) : RenderWindow(tileset, window));
  return ValuesOfColours(expression, picture);
}

Result<IndexValues> ValuesOfWindow(MapBands& map_bands, const storage::Tileset& tileset,
                                   const indices::BandExpression& expression, const MapWindow& window) {
  SKYQUILT_TRY_ASSIGN(const auto raster, map_bands.Of(tileset));
  if (!raster) {
    SKYQUILT_TRY(PlacesOf(expression, ColourBands()));
    SKYQUILT_TRY_ASSIGN(const image::RgbaImage picture, RenderWindow(tileset, window));
    return ValuesOfColours(expression, picture);
  }
  if (window.merc_of) {
    const std::optional<storage::MercGrid> around = GridAround(window);
    if (!around) return Error{ErrorCode::kNotFound, "This window lies nowhere on Earth."};
    SKYQUILT_TRY_ASSIGN(const IndexValues equal, ValuesOfRaster(*raster, expression, *around));
    return WarpedFrom(equal, window, *around);
  }
  const storage::MercGrid grid = GridOver(window);
  SKYQUILT_TRY_ASSIGN(IndexValues equal, ValuesOfRaster(*raster, expression, grid));
  return WithRowsOf(std::move(equal), window, grid);
}

Result<std::optional<double>> ValueAt(MapBands& map_bands, const storage::Tileset& tileset,
                                      const indices::BandExpression& expression,
                                      const Eigen::Vector2d& merc) {
  SKYQUILT_TRY_ASSIGN(const IndexValues pixel,
                      ValuesOfWindow(map_bands, tileset, expression, WindowOfFinestPixel(tileset, merc)));
  if (pixel.alphas[0] == 0) return std::optional<double>();
  return std::optional<double>(pixel.values[0]);
}

image::RgbaImage Coloured(const IndexValues& values, const IndexLook& look) {
  image::RgbaImage picture = image::RgbaImage::Transparent(values.width_px, values.height_px);
  std::uint8_t* pixel = picture.rgba.data();
  for (std::size_t i = 0; i < values.values.size(); ++i, pixel += 4) {
    if (values.alphas[i] == 0) continue;
    const int level = indices::ColourRamp::LevelOf(values.values[i], look.least, look.most);
    const indices::ColourRamp::Colour& colour = look.ramp.At(level);
    std::copy(colour.begin(), colour.end(), pixel);
    pixel[3] = values.alphas[i];
  }
  return picture;
}

}  // namespace skyquilt::api
