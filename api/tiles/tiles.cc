#include "api/tiles/tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "api/http/etag.h"
#include "api/http/problem.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/tiles/cut_tile.h"
#include "api/tiles/map_window.h"
#include "api/tiles/tile_path.h"
#include "api/tiles/transcode_tile.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"

namespace skyquilt::api {
namespace {

constexpr const char* kRevalidated = "public, max-age=60, must-revalidate";
constexpr const char* kGrowing = "no-cache";  // a preview: another edition may come any moment
constexpr const char* kEnded = "no-store";  // what was asked for is no more, and nothing is to be kept of it
constexpr const char* kImmutable = "public, max-age=31536000, immutable";

Result<EmptyTile> ParseEmptyTile(const Request& request, EmptyTile otherwise) {
  const auto wanted = request.Query("empty");
  if (!wanted) return otherwise;
  if (*wanted == "blank") return EmptyTile::kBlank;
  if (*wanted == "204") return EmptyTile::kNoContent;
  if (*wanted == "404") return EmptyTile::kNotFound;
  return Error{ErrorCode::kInvalidArgument, "The parameter \"empty\" must be blank, 204 or 404.", ""};
}

bool Touches(const geo::TileId& tile, const storage::Revision& revision) {
  return tile.BoundsInMerc().Intersects(geo::MercFromLatLonBounds(revision.bounds));
}

// Not on this thread: the request is repeated where such work is done.
Response DeferTo(Work work) {
  Response response;
  response.wants = work;
  return response;
}

// Made once for each size that occurs (256 and 512 as a rule). Null: it is still to be made, but not here.
const std::string* BlankTile(int side_px, Work work) {
  static std::mutex mutex;
  static std::map<int, std::string> made;
  {
    const std::lock_guard lock(mutex);
    const auto found = made.find(side_px);
    if (found != made.end()) return &found->second;
  }
  if (work < Work::kCompute) return nullptr;
  std::string png = TransparentPng(side_px);
  const std::lock_guard lock(mutex);
  return &made.try_emplace(side_px, std::move(png)).first->second;
}

// An address that names the revision it shows never changes its bytes.
const char* CacheControl(const Request& request, const storage::Tileset& tileset) {
  const auto revision = request.Query("rev");
  return revision && *revision == std::to_string(tileset.revision.revision) ? kImmutable : kRevalidated;
}

Result<Response> Blank(const Request& request, const TileRequest& wanted, int side_px,
                       const char* cache_control) {
  SKYQUILT_TRY_ASSIGN(const EmptyTile empty, ParseEmptyTile(request, wanted.empty));
  if (empty == EmptyTile::kNotFound) return Error{ErrorCode::kNotFound, "The map has nothing here.", ""};
  Response response;
  response.headers.Add("Cache-Control", cache_control);
  if (empty == EmptyTile::kNoContent) {
    response.status = 204;
    return response;
  }
  const std::string etag = "\"blank-" + std::to_string(side_px) + "\"";
  response.headers.Add("ETag", etag);
  if (EtagListMatches(request.headers.Find("If-None-Match"), etag)) {
    response.status = 304;
    return response;
  }
  const std::string* png = BlankTile(std::min(side_px, image::kMaxPictureSidePx), request.work);
  if (png == nullptr) return DeferTo(Work::kCompute);
  response.headers.Add("Content-Type", "image/png");
  response.body = *png;
  return response;
}

// Made of the four tiles below it, or enlarged where there are none.
Result<std::string> MakeDoubleTile(const storage::Tileset& tileset, const geo::TileId& tile,
                                   image::PictureFormat format) {
  const geo::Bounds2 bounds = tile.BoundsInMerc();
  MapWindow window;
  window.width_px = window.height_px = 2 * TileSizePx(tileset);
  window.pixel_m = (bounds.max.x() - bounds.min.x()) / window.width_px;
  window.x_in_merc = [&](int column) { return bounds.min.x() + (column + 0.5) * window.pixel_m; };
  window.y_in_merc = [&](int row) { return bounds.max.y() - (row + 0.5) * window.pixel_m; };
  SKYQUILT_TRY_ASSIGN(image::RgbaImage pixels, RenderWindow(tileset, window));
  return EncodeTile(std::move(pixels), format);
}

// From those that were made before, or made here if this is the place. Null: it is not.
Result<std::shared_ptr<const storage::MadeTile>> Made(Service& service, const Request& request,
                                                      const storage::MadeTileKey& key,
                                                      const std::function<Result<std::string>()>& make) {
  if (request.work < Work::kCompute) return service.made_tiles.Find(key);
  return service.made_tiles.Get(key, make);
}

Result<Response> DoubleTile(Service& service, const Request& request, const storage::Tileset& tileset,
                            const TileRequest& wanted) {
  if (2 * TileSizePx(tileset) > image::kMaxPictureSidePx) {
    return Error{ErrorCode::kNotFound,
                 "The tiles of this map are so large that there are none of twice the size.", ""};
  }
  const image::PictureFormat format = wanted.format.value_or(image::PictureFormat::kPng);
  SKYQUILT_TRY_ASSIGN(
      const auto made,
      Made(service, request, {tileset.flight_id, tileset.revision.revision, wanted.tile, format, 2},
           [&] { return MakeDoubleTile(tileset, wanted.tile, format); }));
  if (made == nullptr) return DeferTo(Work::kCompute);
  Response response;
  const std::string etag = StrongEtag(made->digest, "2x");
  response.headers.Add("Cache-Control", CacheControl(request, tileset));
  response.headers.Add("ETag", etag);
  if (EtagListMatches(request.headers.Find("If-None-Match"), etag)) {
    response.status = 304;
    return response;
  }
  response.headers.Add("Content-Type", image::ContentTypeOf(format));
  response.body = made->bytes;
  return response;
}

// The format in Accept, where the address has none: an exact image type, or else as stored.
std::optional<image::PictureFormat> FormatByAccept(const Request& request) {
  const std::string_view accept = request.headers.Find("Accept");
  for (const auto format :
       {image::PictureFormat::kPng, image::PictureFormat::kJpeg, image::PictureFormat::kWebp}) {
    if (EqualsIgnoringCase(accept, image::ContentTypeOf(format))) return format;
  }
  return std::nullopt;
}

// What a tile request is answered from: the map, a layer beside it, or the preview of a map to come.
struct ShownTiles {
  storage::TileSource& source;
  const char* name;
  int side_px;
  std::optional<std::pair<int, int>> zooms;  // absent: any; what it does not have is blank
  const storage::Tileset* tileset;  // absent: a preview, which grows, so that nothing made of it is kept
  const char* cache_control;
  int depth = 0;  // zooms that what is asked for lies deeper than what is stored
};

// A tile as it is stored, or in the format asked for.
Result<Response> Stored(Service& service, const Request& request, const TileRequest& wanted,
                        storage::FoundTile found, const ShownTiles& shown) {
  Response response;
  response.headers.Add("Cache-Control", shown.cache_control);
  // The format asked for is part of the tag: the same content has other bytes in another format.
  std::string etag = StrongEtag(found.content_id, wanted.format ? image::ExtensionOf(*wanted.format) : "");
  const bool is_known = EtagListMatches(request.headers.Find("If-None-Match"), etag);
  response.headers.Add("ETag", std::move(etag));
  if (is_known) {
    response.status = 304;
    return response;
  }
  SKYQUILT_TRY_ASSIGN(std::string bytes,
                      found.bytes ? *std::move(found.bytes) : shown.source.Load(std::move(found)));
  const std::optional<image::PictureFormat> stored = image::PictureFormatOf(bytes);
  if (wanted.format && stored && *wanted.format != *stored) {
    response.headers.Add("Content-Type", image::ContentTypeOf(*wanted.format));
    if (shown.tileset == nullptr) {
      if (request.work < Work::kCompute) return DeferTo(Work::kCompute);
      SKYQUILT_TRY_ASSIGN(std::string converted, TranscodeTile(bytes, *wanted.format));
      response.body = std::move(converted);
      return response;
    }
    const storage::MadeTileKey key{shown.tileset->flight_id, shown.tileset->revision.revision, wanted.tile,
                                   *wanted.format, 1};
    SKYQUILT_TRY_ASSIGN(const auto made,
                        Made(service, request, key, [&] { return TranscodeTile(bytes, *wanted.format); }));
    if (made == nullptr) return DeferTo(Work::kCompute);
    response.body = made->bytes;
    return response;
  }
  response.headers.Add("Content-Type", stored ? image::ContentTypeOf(*stored) : "application/octet-stream");
  response.body = std::move(bytes);
  return response;
}

// A part of a stored tile.
Result<Response> Cut(Service& service, const Request& request, const TileRequest& wanted,
                     storage::FoundTile found, const ShownTiles& shown, const TileCut& cut) {
  const std::string etag =
      StrongEtag(found.content_id, fmt::format("{}-{}-{}{}", cut.side_px, cut.left_px, cut.top_px,
                                               wanted.format ? image::ExtensionOf(*wanted.format) : ""));
  Response response;
  response.headers.Add("Cache-Control", shown.cache_control);
  response.headers.Add("ETag", etag);
  if (EtagListMatches(request.headers.Find("If-None-Match"), etag)) {
    response.status = 304;
    return response;
  }
  SKYQUILT_TRY_ASSIGN(const std::string bytes,
                      found.bytes ? *std::move(found.bytes) : shown.source.Load(std::move(found)));
  const image::PictureFormat format =
      wanted.format ? *wanted.format : image::PictureFormatOf(bytes).value_or(image::PictureFormat::kPng);
  const storage::MadeTileKey key{
      shown.tileset->flight_id, shown.tileset->revision.revision, wanted.tile, format, 1, cut.side_px};
  SKYQUILT_TRY_ASSIGN(const auto made,
                      Made(service, request, key, [&] { return CutTile(bytes, cut, format); }));
  if (made == nullptr) return DeferTo(Work::kCompute);
  if (made->bytes.empty()) return Blank(request, wanted, cut.side_px, shown.cache_control);
  response.headers.Add("Content-Type", image::ContentTypeOf(format));
  response.body = made->bytes;
  return response;
}

Result<Response> AnswerFrom(const ShownTiles& shown, Service& service, const Request& request,
                            const TileRequest& wanted) {
  // There is nothing finer to show for a preview.
  const bool is_double = wanted.is_double && shown.tileset != nullptr;
  const int side_px = (shown.side_px >> shown.depth) * (is_double ? 2 : 1);
  const int stored_zoom = wanted.tile.z() - shown.depth;
  if (shown.zooms && (stored_zoom < shown.zooms->first || stored_zoom > shown.zooms->second)) {
    if (wanted.is_of_world && stored_zoom < shown.zooms->first) {
      return Blank(request, wanted, side_px, shown.cache_control);
    }
    return Error{ErrorCode::kNotFound, fmt::format("The {} has no tiles of this zoom.", shown.name), ""};
  }
  const TileCut cut = CutOf(wanted.tile, shown.depth, shown.side_px);
  if (request.work < Work::kRead && !shown.source.IsAtHand(cut.stored)) return DeferTo(Work::kRead);
  SKYQUILT_TRY_ASSIGN(std::optional<storage::FoundTile> found, shown.source.Find(cut.stored));
  if (!found) {
    if (shown.tileset != nullptr && !wanted.is_of_world && !Touches(wanted.tile, shown.tileset->revision)) {
      return Error{ErrorCode::kNotFound, "This tile lies outside the map.", ""};
    }
    return Blank(request, wanted, side_px, shown.cache_control);
  }
  if (shown.depth > 0) return Cut(service, request, wanted, *std::move(found), shown, cut);
  if (is_double) return DoubleTile(service, request, *shown.tileset, wanted);
  return Stored(service, request, wanted, *std::move(found), shown);
}

// Codes, not pictures: as they are stored, in no other size or format.
Result<Response> LayerTile(Service& service, const Request& request, const storage::Tileset& tileset,
                           const TileRequest& wanted) {
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<storage::MapTiles> reader, FindLayer(tileset, *wanted.layer));
  if (wanted.is_double || wanted.format.value_or(image::PictureFormat::kPng) != image::PictureFormat::kPng) {
    return Error{ErrorCode::kInvalidArgument,
                 "Layers are there as .png of one size: their colours are codes.", ""};
  }
  TileRequest as_stored = wanted;
  as_stored.format.reset();
  return AnswerFrom(
      {*reader, "layer", render::kLayerTilePx, std::nullopt, &tileset, CacheControl(request, tileset)},
      service, request, as_stored);
}

// A tile of a map that is not made yet.
Result<Response> PreviewTile(Service& service, const Request& request, const TileRequest& wanted) {
  SKYQUILT_TRY(CheckId(wanted.flight_id, "flight"));
  const Result<std::shared_ptr<const storage::OpenPreview>> open =
      service.preview_cache.Get(wanted.flight_id);
  if (!open) {
    // Who shows the preview learns of its end a moment after it: until then it has nothing more, which is no
    // mistake.
    if (service.tilesets.Get(wanted.flight_id)) return Blank(request, wanted, kPreviewTileSizePx, kEnded);
    return open.error();
  }
  const storage::Preview& preview = (*open)->preview;
  return AnswerFrom({*(*open)->tiles, "preview", kPreviewTileSizePx,
                     std::pair(preview.min_zoom, preview.max_zoom), nullptr, kGrowing},
                    service, request, wanted);
}

Result<Response> Tile(Service& service, const Request& request, std::optional<int> side_px) {
  SKYQUILT_TRY_ASSIGN(const TilePath path,
                      ParseTilePath(request.Parameter("z"), request.Parameter("x"), request.Parameter("y")));
  TileRequest wanted;
  wanted.flight_id = request.Parameter("flight");
  wanted.tile = path.tile;
  wanted.format = path.format ? path.format : FormatByAccept(request);
  wanted.is_double = path.is_double;
  wanted.side_px = side_px;
  // Previews are written while they are read, and a map is opened by whoever asks first.
  const bool is_open = service.tilesets.IsOpen(wanted.flight_id) && request.Query("rev") != kPreviewRevision;
  if (request.work < Work::kRead && !is_open) return DeferTo(Work::kRead);
  Result<Response> answer = ShowsPreview(service, request, wanted.flight_id)
                                ? PreviewTile(service, request, wanted)
                                : AnswerTile(service, request, wanted);
  if (answer && !path.format) answer->headers.Add("Vary", "Accept");
  return answer;
}

}  // namespace

bool ShowsPreview(Service& service, const Request& request, const std::string& flight_id) {
  const auto revision = request.Query("rev");
  if (revision) return *revision == kPreviewRevision;
  // The map first: once it exists, the preview is shown only under its own name.
  if (!CheckId(flight_id, "flight") || service.tilesets.Get(flight_id)) return false;
  return service.preview_cache.Get(flight_id).ok();
}

Result<Response> AnswerTile(Service& service, const Request& request, const TileRequest& wanted) {
  SKYQUILT_TRY(CheckId(wanted.flight_id, "flight"));
  if (request.work < Work::kRead && !service.tilesets.IsOpen(wanted.flight_id)) return DeferTo(Work::kRead);
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset,
                      service.tilesets.Get(wanted.flight_id));
  const storage::Revision& revision = tileset->revision;
  if (wanted.layer) return LayerTile(service, request, *tileset, wanted);
  ShownTiles shown{*tileset->reader,     "map",
                   TileSizePx(*tileset), std::pair(revision.min_zoom, revision.max_zoom),
                   tileset.get(),        CacheControl(request, *tileset)};
  if (!wanted.side_px || *wanted.side_px == shown.side_px) return AnswerFrom(shown, service, request, wanted);
  // One of twice the side is a larger part of a stored tile, or a whole one.
  const std::optional<int> depth = CutDepth(*wanted.side_px * (wanted.is_double ? 2 : 1), shown.side_px);
  if (!depth && *wanted.side_px == kUsualTilePx) return AnswerFrom(shown, service, request, wanted);
  if (!depth) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("The tiles of this map have {} pixels, and those of {} cannot be cut from them.",
                             shown.side_px, *wanted.side_px),
                 ""};
  }
  shown.depth = *depth;
  TileRequest part = wanted;
  part.is_double = false;
  return AnswerFrom(shown, service, request, part);
}

int TileSizePx(const storage::Tileset& tileset) {
  const auto& metadata = tileset.reader->metadata();
  const auto found = metadata.find("tile_size");
  int side_px = 0;
  if (found != metadata.end()) {
    std::from_chars(found->second.data(), found->second.data() + found->second.size(), side_px);
  }
  return side_px >= 64 && side_px <= 4096 ? side_px : 256;
}

Response TileResponse(Result<Response> answer, const Request& request) {
  Response response = answer ? *std::move(answer) : Problem(answer.error(), request);
  return response;
}

Result<std::shared_ptr<storage::MapTiles>> FindLayer(const storage::Tileset& tileset,
                                                     render::MapLayer layer) {
  const auto found = tileset.layers.find(layer);
  if (found != tileset.layers.end()) return found->second;
  return Error{
      ErrorCode::kNotFound,
      fmt::format("The map was made without the layer \"{0}\". Start a job with \"layers\": [\"{0}\"].",
                  render::NameOf(layer)),
      ""};
}

Result<render::MapLayer> ParseLayer(std::string_view name) {
  const std::optional<render::MapLayer> layer = render::MapLayerNamed(name);
  if (layer) return *layer;
  return Error{ErrorCode::kNotFound, "There is no such layer; there are photo, error and height.", ""};
}

void AddTileRoutes(Router& router, Service& service) {
  router.AddQuick(Method::kGet, "/tiles/{flight}/{z}/{x}/{y}", [&](const Request& request) {
    return TileResponse(Tile(service, request, std::nullopt), request);
  });
  router.AddQuick(Method::kGet, "/tiles/{flight}/256/{z}/{x}/{y}", [&](const Request& request) {
    return TileResponse(Tile(service, request, kUsualTilePx), request);
  });
  router.AddQuick(Method::kGet, "/tiles/{flight}/{layer}/{z}/{x}/{y}", [&](const Request& request) {
    const Result<render::MapLayer> layer = ParseLayer(request.Parameter("layer"));
    if (!layer) return TileResponse(layer.error(), request);
    const Result<TilePath> path =
        ParseTilePath(request.Parameter("z"), request.Parameter("x"), request.Parameter("y"));
    if (!path) return TileResponse(path.error(), request);
    TileRequest wanted;
    wanted.flight_id = request.Parameter("flight");
    wanted.layer = *layer;
    wanted.tile = path->tile;
    wanted.format = path->format;
    wanted.is_double = path->is_double;
    return TileResponse(AnswerTile(service, request, wanted), request);
  });
}

}  // namespace skyquilt::api
