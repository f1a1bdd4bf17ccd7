// Downloads of a finished map, and of the user's own files: a photo as it was uploaded is shown in the
// browser where possible; any other file is sent as a download only, so that nothing uploaded runs as part of
// the page.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/common/find_flight.h"
#include "api/downloads/send_file.h"
#include "api/downloads/streamed_product.h"
#include "api/downloads/zip_layout.h"
#include "api/http/conditional.h"
#include "api/http/responses.h"
#include "api/routes.h"
#include "api/tiles/map_window.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tiles.h"
#include "core/base/text/plain_text.h"
#include "core/base/try.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"
#include "core/image/shrink/shrink_picture.h"
#include "storage/caches/tileset_cache.h"
#include "storage/files/publish_file.h"

namespace skyquilt::api {
namespace {

struct Product {
  const char* file;  // in the revision's folder
  const char* content_type;
  const char* extension;  // of the name offered for saving; none: shown in the browser
};

// From the map that the flight shows. A revision retired between the look-up and the opening is looked up
// again.
Result<Response> OfShownMap(Service& service, const std::string& flight_id,
                            const std::function<Result<Response>(const ShownMap&)>& answer) {
  constexpr int kTries = 3;
  for (int attempt = 1;; ++attempt) {
    SKYQUILT_TRY_ASSIGN(const ShownMap map, FindShownMap(service, flight_id));
    Result<Response> sent = answer(map);
    if (sent || sent.error().code != ErrorCode::kNotFound || attempt == kTries) return sent;
  }
}

bool IsStreamed(const std::string& name) {
  return std::find(std::begin(kStreamedProducts), std::end(kStreamedProducts), name) !=
         std::end(kStreamedProducts);
}

// The file that the map has, as maps of earlier versions do; else what is laid out over its tiles.
Result<Response> SendProduct(Service& service, const Request& request, const ShownMap& map,
                             const std::string& id, const Product& product) {
  Result<Response> sent =
      SendBlob(request, service.store.blobs(), map.prefix + product.file, product.content_type,
               fmt::format("\"{}-r{}-{}\"", id, map.revision, product.file));
  if (sent || sent.error().code != ErrorCode::kNotFound || !IsStreamed(product.file)) return sent;
  SKYQUILT_TRY_ASSIGN(const storage::OpenStreamed streamed,
                      OpenStreamedProduct(service, map.prefix, product.file));
  return SendStreamed(request, streamed, product.content_type);
}

Result<Response> Send(Service& service, const Request& request, const Product& product) {
  const std::string& id = request.Parameter("flight");
  return OfShownMap(service, id, [&](const ShownMap& map) -> Result<Response> {
    SKYQUILT_TRY_ASSIGN(Response sent, SendProduct(service, request, map, id, product));
    if (product.extension != nullptr && sent.status != 304) {
      sent.headers.Add("Content-Disposition", Disposition(map.flight_name, product.extension));
    }
    sent.headers.Add("Cache-Control", "no-cache");
    return sent;
  });
}

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

// The whole map as a WebP of a few kilobytes, for lists: made from the map's thumbnail when it is asked for,
// kept with the tiles that were made. `?size=` is its longer side, one of few, so that no client fills that
// memory with sizes; the largest, of about a hundred kilobytes, is drawn from the tiles.
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

Result<Response> SendThumbnail(Service& service, const Request& request) {
  const std::string& id = request.Parameter("flight");
  return OfShownMap(service, id,
                    [&](const ShownMap& map) { return SmallPicture(service, request, id, map); });
}

// Everything that the map's folder has, and what can be laid out over its tiles, as one archive.
Result<Response> SendAll(Service& service, const Request& request) {
  const std::string& id = request.Parameter("flight");
  SKYQUILT_TRY_ASSIGN(const ShownMap map, FindShownMap(service, id));
  SKYQUILT_TRY_ASSIGN(const std::vector<storage::BlobInfo> products, service.store.blobs().List(map.prefix));
  std::vector<ZipEntry> entries;
  std::vector<storage::LocalBlob> files;  // stay until the archive has opened them
  for (const storage::BlobInfo& product : products) {
    std::string name = product.key.substr(map.prefix.size());
    if (name.find('/') != std::string::npos) continue;
    SKYQUILT_TRY_ASSIGN(storage::LocalBlob file, service.store.blobs().Local(product.key));
    entries.push_back({std::move(name), "", file.path, {}});
    files.push_back(std::move(file));
  }
  const auto has = [&](const std::string& name) {
    return std::any_of(entries.begin(), entries.end(),
                       [&](const ZipEntry& entry) { return entry.name == name; });
  };
  for (const char* name : kStreamedProducts) {
    if (has(name) || !has("mosaic.mbtiles")) continue;
    Result<storage::OpenStreamed> streamed = OpenStreamedProduct(service, map.prefix, name);
    if (!streamed && streamed.error().code == ErrorCode::kTooLarge) continue;
    if (!streamed) return streamed.error();
    entries.push_back({name, "", {}, *std::move(streamed)});
  }
  if (entries.empty()) return Error{ErrorCode::kNotFound, "The map was replaced this moment. Ask again."};
  SKYQUILT_TRY_ASSIGN(ZipLayout planned, PlanZip(entries));
  const auto layout = std::make_shared<const ZipLayout>(std::move(planned));
  Result<Response> sent =
      SendParts(request, layout->length, "application/zip", ZipEtag(*layout),
                [&](std::uint64_t offset, std::uint64_t length) { return ReadZip(layout, offset, length); });
  if (!sent) return sent.error();
  sent->headers.Add("Content-Disposition", Disposition(map.flight_name, "zip"));
  sent->headers.Add("Cache-Control", "no-cache");
  return sent;
}

constexpr std::array<std::pair<std::string_view, const char*>, 6> kShown = {{
    {".jpg", "image/jpeg"},
    {".jpeg", "image/jpeg"},
    {".png", "image/png"},
    {".webp", "image/webp"},
    {".tif", "image/tiff"},
    {".tiff", "image/tiff"},
}};

const char* ImageTypeOf(std::string_view name) {
  const std::string lower = LowerCase(name);
  for (const auto& [extension, type] : kShown) {
    if (lower.ends_with(extension)) return type;
  }
  return nullptr;
}

// A frame of a film: a photo of the map that nobody uploaded. It lies with the map.
Result<Response> SendFrame(Service& service, const Request& request, const std::string& flight_id,
                           const std::string& name) {
  const Error unknown{ErrorCode::kNotFound, "This flight has no file of this name.", name};
  const bool is_plain = !name.starts_with('.') && name.find_first_of("/\\") == std::string::npos;
  if (!is_plain || !name.ends_with(".jpg")) return unknown;
  const Result<ShownMap> shown = FindShownMap(service, flight_id);
  if (!shown) return unknown;
  Result<Response> sent = SendBlob(request, service.store.blobs(), shown->prefix + "frames/" + name,
                                   "image/jpeg", fmt::format("\"{}-{}\"", shown->revision, name));
  if (!sent && sent.error().code == ErrorCode::kNotFound) return unknown;
  if (sent) sent->headers.Add("Cache-Control", "no-cache");
  return sent;
}

Result<Response> SendOriginal(Service& service, const Request& request) {
  const std::string& flight_id = request.Parameter("flight");
  const std::string& name = request.Parameter("name");
  SKYQUILT_TRY(RequireFlight(service, flight_id));
  SKYQUILT_TRY_ASSIGN(const std::optional<storage::StoredFile> file,
                      service.catalogue.FindFile(flight_id, name));
  if (!file) return SendFrame(service, request, flight_id, name);
  const char* image_type = ImageTypeOf(name);
  // Stored names are never used again: the bytes behind one never change.
  Result<Response> sent = SendBlob(
      request, service.store.blobs(), storage::FilesPrefix(flight_id) + file->stored_name,
      image_type != nullptr ? image_type : "application/octet-stream", "\"" + file->stored_name + "\"");
  if (!sent) return sent.error();
  if (image_type == nullptr) sent->headers.Add("Content-Disposition", "attachment");
  sent->headers.Add("Cache-Control", "no-cache");
  return sent;
}

}  // namespace

void AddDownloadRoutes(Router& router, Service& service) {
  const std::string flight = "/api/v1/flights/{flight}/";
  const auto add = [&](const char* name, Product product) {
    router.Add(Method::kGet, flight + name, [&service, product](const Request& request) {
      return Downloaded(Send(service, request, product), request);
    });
  };
  add("download.mbtiles", {"mosaic.mbtiles", "application/vnd.sqlite3", "mbtiles"});
  add("download.tif", {"mosaic.tif", kCogType, "tif"});
  add("bands.tif", {"bands.tif", kCogType, "tif"});
  add("dsm.tif", {"dsm.tif", kCogType, "dsm.tif"});
  add("dsm_photos.tif", {"dsm_photos.tif", kCogType, "dsm_photos.tif"});
  add("dsm_hillshade.tif", {"dsm_hillshade.tif", kCogType, "dsm_hillshade.tif"});
  add("dtm.tif", {"dtm.tif", kCogType, "dtm.tif"});
  add("dtm_ground.tif", {"dtm_ground.tif", kCogType, "dtm_ground.tif"});
  add("contours.gpkg", {"contours.gpkg", "application/geopackage+sqlite3", "contours.gpkg"});
  add("contours.geojson", {"contours.geojson", "application/geo+json", "contours.geojson"});
  add("contours.dxf", {"contours.dxf", "image/vnd.dxf", "contours.dxf"});
  add("download.pmtiles", {"mosaic.pmtiles", "application/vnd.pmtiles", "pmtiles"});
  add("thumbnail.png", {"thumbnail.png", "image/png", nullptr});
  router.AddCompute(Method::kGet, flight + "thumbnail.webp", [&](const Request& request) {
    return Downloaded(SendThumbnail(service, request), request);
  });
  add("layers.json", {"layers.json", "application/json", nullptr});
  add("layer_photo.mbtiles", {"layer_photo.mbtiles", "application/vnd.sqlite3", "mbtiles"});
  add("layer_error.mbtiles", {"layer_error.mbtiles", "application/vnd.sqlite3", "mbtiles"});
  add("layer_height.mbtiles", {"layer_height.mbtiles", "application/vnd.sqlite3", "mbtiles"});
  add("cameras.json", {"cameras.json", "application/json", nullptr});
  add("geo.txt", {"geo.txt", "text/plain; charset=utf-8", nullptr});
  router.AddCompute(Method::kGet, flight + "download.zip",
                    [&](const Request& request) { return Downloaded(SendAll(service, request), request); });
  add("report", {"report.json", "application/json", nullptr});
  add("photos.geojson", {"photos.geojson", "application/geo+json", nullptr});
}

void AddOriginalFileRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/flights/{flight}/files/{name}",
             [&](const Request& request) { return Downloaded(SendOriginal(service, request), request); });
}

}  // namespace skyquilt::api
