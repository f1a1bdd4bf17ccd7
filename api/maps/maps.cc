// OGC API Maps, Part 1 (OGC 20-058): a flight's map as one picture of any box in any coordinate system, at
// /ogc/collections/{flight}/map, drawn by what WMS draws with and within its limits.
#include <fmt/format.h>

#include <utility>

#include "api/http/responses.h"
#include "api/maps/map_request.h"
#include "api/ogc/ogc_format.h"
#include "api/routes.h"
#include "api/tiles/map_window.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tiles.h"
#include "api/views/map_view.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"

namespace skyquilt::api {
namespace {

// What shows nothing of the map: laid on the colour, or transparent with the colour kept for who looks at it.
void LayOnBackground(std::uint8_t* pixel, const Rgb& colour, bool is_transparent) {
  if (!is_transparent) {
    LayOn(pixel, colour);
  } else if (pixel[3] == 0) {
    std::copy(colour.begin(), colour.end(), pixel);
  }
}

void LayOnBackground(image::RgbaImage& picture, const MapRequest& wanted) {
  const MapBackground& background = wanted.background;
  const Eigen::Vector2d pixel(wanted.box.Width() / picture.width_px, wanted.box.Height() / picture.height_px);
  for (int row = 0; row < picture.height_px; ++row) {
    const double y = wanted.box.max.y() - (row + 0.5) * pixel.y();
    for (int column = 0; column < picture.width_px; ++column) {
      std::uint8_t* const at = picture.Pixel(column, row);
      const bool is_void = !background.is_one() && at[3] == 0 &&
                           !wanted.crs.LatLonOf({wanted.box.min.x() + (column + 0.5) * pixel.x(), y});
      LayOnBackground(at, is_void ? background.void_colour : background.colour,
                      is_void ? background.is_void_transparent : background.is_transparent);
    }
  }
}

// In the order of the system's axes.
std::string CornersOf(const MapRequest& wanted) {
  const auto& [low, high] = wanted.box;
  return wanted.crs.is_north_first() ? fmt::format("{},{},{},{}", low.y(), low.x(), high.y(), high.x())
                                     : fmt::format("{},{},{},{}", low.x(), low.y(), high.x(), high.y());
}

Result<Response> AnswerMap(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const image::PictureFormat format, PictureFormatFor(request));
  SKYQUILT_TRY_ASSIGN(const MapView map, FindMap(service, request, request.Parameter("flight")));
  const storage::Tileset& tileset = *map.tileset;
  const WholeMap whole{tileset.revision.bounds,
                       geo::PixelSizeInMercM(tileset.revision.max_zoom, TileSizePx(tileset))};
  SKYQUILT_TRY_ASSIGN(MapRequest wanted, ParseMapRequest(request, whole));
  if (format == image::PictureFormat::kJpeg) {
    wanted.background.is_transparent = wanted.background.is_void_transparent = false;
  }
  const MapWindow window =
      WindowOf(wanted.crs, wanted.box, wanted.width_px, wanted.height_px, whole.bounds.Middle());
  SKYQUILT_TRY_ASSIGN(image::RgbaImage picture, RenderWindow(tileset, window));
  LayOnBackground(picture, wanted);
  Response response =
      NoCache(Text(200, EncodeTile(std::move(picture), format), image::ContentTypeOf(format)));
  if (!wanted.crs.is_crs84()) response.headers.Add("Content-Crs", wanted.crs.uri());
  response.headers.Add("Content-Bbox", CornersOf(wanted));
  if (!request.Query("f")) TellByAccept(response);
  return response;
}

}  // namespace

void AddMapRoutes(Router& router, Service& service) {
  router.AddCompute(Method::kGet, "/ogc/collections/{flight}/map", On(service, AnswerMap));
}

}  // namespace skyquilt::api
