#include "api/downloads/map_poster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "api/tiles/map_window.h"
#include "api/tiles/tiles.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"

namespace skyquilt::api {
namespace {

// It is looked at for a second, over lines on which every kilobyte is waited for: a map with much detail is
// encoded once more.
constexpr std::array kPosterQualities = {60.0F, 35.0F};
constexpr std::size_t kWantedPosterBytes = 110'000;

int SidePx(double length_m, double pixel_m) {
  return std::clamp(static_cast<int>(std::lround(length_m / pixel_m)), 1, kPosterSizePx);
}

}  // namespace

Result<std::string> DrawMapPoster(const storage::Tileset& tileset) {
  const geo::Bounds2 bounds = geo::MercFromLatLonBounds(tileset.revision.bounds);
  const double finest_m = geo::PixelSizeInMercM(tileset.revision.max_zoom, TileSizePx(tileset));
  const double pixel_m = std::max(std::max(bounds.Width(), bounds.Height()) / kPosterSizePx, finest_m);
  MapWindow window;
  window.width_px = SidePx(bounds.Width(), pixel_m);
  window.height_px = SidePx(bounds.Height(), pixel_m);
  // Whole pixels, so that the corners lie on those of the bounds: not quite square.
  const double column_m = bounds.Width() / window.width_px;
  const double row_m = bounds.Height() / window.height_px;
  window.x_in_merc = [&](int column) { return bounds.min.x() + (column + 0.5) * column_m; };
  window.y_in_merc = [&](int row) { return bounds.max.y() - (row + 0.5) * row_m; };
  window.pixel_m = std::min(column_m, row_m);
  SKYQUILT_TRY_ASSIGN(const image::RgbaImage picture, RenderWindow(tileset, window));
  std::vector<std::uint8_t> bytes;
  for (const float quality : kPosterQualities) {
    bytes = image::EncodeWebp(image::RowsOf(picture), quality);
    if (bytes.size() <= kWantedPosterBytes) break;
  }
  return std::string(bytes.begin(), bytes.end());
}

}  // namespace skyquilt::api
