#include "api/downloads/small_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "api/http/conditional.h"
#include "api/tiles/map_window.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tiles.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"
#include "core/image/shrink/shrink_picture.h"
#include "storage/caches/tileset_cache.h"
#include "storage/files/publish_file.h"

namespace skyquilt::api {
namespace {

constexpr int kPosterSizePx = 1024;  // its longer side; a smaller map is not enlarged

// It is looked at for a second, over lines on which every kilobyte is waited for: a map with much detail is
// encoded once more.
constexpr std::array kPosterQualities = {60.0F, 35.0F};
constexpr std::size_t kWantedPosterBytes = 110'000;

int SidePx(double length_m, double pixel_m) {
  return std::clamp(static_cast<int>(std::lround(length_m / pixel_m)), 1, kPosterSizePx);
}

// From the tiles, exactly as far as the map's bounds reach and in Web Mercator: laid on these bounds it lies
// where the tiles will, while the library that draws them is on its way to the page.
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

constexpr std::array kSizesPx = {160, 320, 512, kPosterSizePx};
constexpr int kUsualSizePx = 320;

Result<int> SizeAsked(const Request& request) {
  const auto text = request.Query("size");
  if (!text) return kUsualSizePx;
  for (const int size_px : kSizesPx) {
    if (*text == std::to_string(size_px)) return size_px;
  }
  return Error{ErrorCode::kInvalidArgument,
               "The parameter \"size\", the picture's longer side in pixels, must be 160, 320, 512 or 1024."};
}

Result<std::string> MakePoster(Service& service, const std::string& flight_id, const ShownMap& map) {
  SKYQUILT_TRY_ASSIGN(const auto tileset, service.tilesets.Get(flight_id));
  if (tileset->revision.revision != map.revision)
    return Error{ErrorCode::kNotFound, "The map was replaced this moment. Ask again."};
  return DrawMapPoster(*tileset);
}

Result<std::string> MakePicture(Service& service, const std::string& flight_id, const ShownMap& map,
                                int size_px) {
  if (size_px == kPosterSizePx) return MakePoster(service, flight_id, map);
  SKYQUILT_TRY_ASSIGN(const storage::LocalBlob thumbnail, FetchProduct(service, map, "thumbnail.png"));
  SKYQUILT_TRY_ASSIGN(const std::string bytes, storage::ReadWholeFile(thumbnail.path));
  SKYQUILT_TRY_ASSIGN(image::RgbaImage whole, image::DecodePicture(bytes));
  return EncodeTile(image::ShrinkPicture(std::move(whole), size_px), image::PictureFormat::kWebp);
}

}  // namespace

Result<Response> SmallPicture(Service& service, const Request& request, const std::string& flight_id,
                              const ShownMap& map) {
  SKYQUILT_TRY_ASSIGN(const int size_px, SizeAsked(request));
  constexpr auto kFormat = image::PictureFormat::kWebp;
  const storage::MadeTileKey key{flight_id, map.revision, {}, kFormat, 1, 0, size_px};
  SKYQUILT_TRY_ASSIGN(const auto picture, service.made_tiles.Get(key, [&] {
    return MakePicture(service, flight_id, map, size_px);
  }));
  const std::string etag = fmt::format("\"{}-r{}-thumbnail-{}.{}\"", flight_id, map.revision, size_px,
                                       image::ExtensionOf(kFormat));
  Response response;
  response.headers.Add("ETag", etag);
  response.headers.Add("Cache-Control", "no-cache");
  if (EtagListMatches(request.headers.Find("If-None-Match"), etag)) {
    response.status = 304;
    return response;
  }
  response.headers.Add("Content-Type", image::ContentTypeOf(kFormat));
  response.body = picture->bytes;
  return response;
}

}  // namespace skyquilt::api
