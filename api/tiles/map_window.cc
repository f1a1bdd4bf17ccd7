#include "api/tiles/map_window.h"

#include <cmath>
#include <vector>

#include "api/tiles/tiles.h"
#include "api/tiles/warped_window.h"
#include "api/tiles/zoom_picture.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

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

Result<image::RgbaImage> RenderWindow(const storage::Tileset& tileset, const MapWindow& window) {
  const int zoom = ZoomFor(tileset, window.pixel_m);
  if (window.merc_of) return RenderWarpedWindow(tileset, zoom, window);
  ZoomPicture picture(tileset, zoom);
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
