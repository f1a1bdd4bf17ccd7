// The parameters of WMS, of OGC API Maps and of tile addresses, as they come in a query.
#include <cmath>
#include <cstdint>
#include <string>

#include "api/http/target.h"
#include "api/maps/map_request.h"
#include "api/tiles/tile_path.h"
#include "api/wms/wms_request.h"
#include "core/base/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt::api;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  auto query = ParseQuery(text);
  if (!query) return 0;
  Request request;
  request.query = *std::move(query);
  if (const auto map = ParseGetMap(request)) {
    SKYQUILT_CHECK(map->width_px >= 1 && map->height_px >= 1 && map->width_px * map->height_px <= (8 << 20),
                   "a picture beyond the limit");
    SKYQUILT_CHECK(std::isfinite(map->east - map->west) && map->west < map->east && map->south < map->north,
                   "a window that is none");
  }
  if (const auto info = ParseGetFeatureInfo(request)) {
    SKYQUILT_CHECK(info->column >= 0 && info->column < info->map.width_px && info->row >= 0 &&
                       info->row < info->map.height_px,
                   "a pixel beside the picture");
    SKYQUILT_CHECK(info->map.layers.size() <= kMaxWmsLayers, "layers beyond the limit");
  }
  const WholeMap whole{{8.29, 47.09, 8.31, 47.11}, 0.3};
  if (const auto map = ParseMapRequest(request, whole)) {
    SKYQUILT_CHECK(map->width_px >= 1 && map->height_px >= 1 && map->width_px <= kMaxWmsSidePx &&
                       map->height_px <= kMaxWmsSidePx && map->width_px * map->height_px <= kMaxWmsPixels,
                   "a picture beyond the limit");
    SKYQUILT_CHECK(map->box.min.allFinite() && map->box.max.allFinite() && map->box.Width() > 0.0 &&
                       map->box.Height() > 0.0,
                   "a window that is none");
  }
  if (request.query.size() >= 3) {
    const auto path =
        ParseTilePath(request.query[0].second, request.query[1].second, request.query[2].second);
    if (path) SKYQUILT_CHECK(path->tile.z() <= 30, "a zoom beyond the last");
    const auto numbers =
        ParseTileNumbers(request.query[0].second, request.query[1].second, request.query[2].second);
    if (numbers) SKYQUILT_CHECK(numbers->x >= 0 && numbers->y >= 0, "a tile before the first");
  }
  return 0;
}
