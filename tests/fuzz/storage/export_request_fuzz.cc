// What somebody asks of an export, with its boundary in GeoJSON.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/base/check.h"
#include "storage/exports/custom/export_request.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  (void)storage::ParseExportRequest(text).ok();
  (void)storage::ParseArea(text).ok();
  const auto boundary = storage::ParseBoundary(text);
  if (!boundary) return 0;
  SKYQUILT_CHECK(!boundary->polygons.empty(), "a boundary without a polygon");
  std::vector<std::uint8_t> inside;
  for (const int zoom : {0, 3}) {
    const storage::BoundaryOnZoom on_zoom(*boundary, zoom, 64);
    const geo::TileId tile = geo::TileId::AtMerc(zoom, {1000.0, 1000.0});
    const storage::Cover cover = on_zoom.Mask(tile, inside);
    SKYQUILT_CHECK(inside.size() == 64 * 64, "a mask of another size than its tile");
    const auto count = static_cast<std::size_t>(std::count(inside.begin(), inside.end(), std::uint8_t{1}));
    SKYQUILT_CHECK((cover == storage::Cover::kAll) == (count == inside.size()) &&
                       (cover == storage::Cover::kNone) == (count == 0),
                   "a cover that its mask does not have");
  }
  return 0;
}
