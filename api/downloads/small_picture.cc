#include "api/downloads/small_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string_view>
#include <utility>

#include "api/downloads/map_poster.h"
#include "api/http/etag.h"
#include "api/tiles/transcode_tile.h"
#include "core/base/try.h"
#include "core/image/picture_codec.h"
#include "core/image/shrink/shrink_picture.h"
#include "storage/files/publish_file.h"

namespace skyquilt::api {
namespace {

constexpr std::array kSizesPx = {160, 320, 512, kPosterSizePx};
constexpr int kUsualSizePx = 320;

Result<int> SizeAsked(const Request& request) {
  const auto text = request.Query("size");
  if (!text) return kUsualSizePx;
  for (const int size_px : kSizesPx) {
    if (*text == std::to_string(size_px)) return size_px;
  }
  return Error{ErrorCode::kInvalidArgument,
               "The parameter \"size\", the picture's longer side in pixels, must be 160, 320, 512 or 1024.",
               ""};
}

Result<std::string> MakePoster(Service& service, const std::string& flight_id, const ShownMap& map) {
  SKYQUILT_TRY_ASSIGN(const auto tileset, service.tilesets.Get(flight_id));
  if (tileset->revision.revision != map.revision)
    return Error{ErrorCode::kNotFound, "The map was replaced this moment. Ask again.", ""};
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
