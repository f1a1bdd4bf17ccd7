#include "api/tiles/tiles.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "api/http/accept.h"
#include "api/http/conditional.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/routes.h"
#include "api/tiles/index_values.h"
#include "api/tiles/map_window.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tile_answer.h"
#include "api/tiles/tile_path.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"

namespace skyquilt::api {
namespace {

constexpr const char* kGrowing = "no-cache";  // a preview: another edition may come any moment
constexpr const char* kEnded = "no-store";  // what was asked for is no more, and nothing is to be kept of it

bool Touches(const geo::TileId& tile, const storage::Revision& revision) {
  const geo::Bounds2 map = geo::MercFromLatLonBounds(revision.bounds);
  geo::Bounds2 bounds = tile.BoundsInMerc();
  if (bounds.Intersects(map)) return true;
  // East of the antimeridian a map goes on at the other end of the world.
  bounds.min.x() += 2.0 * geo::kMercHalfWidthM;
  bounds.max.x() += 2.0 * geo::kMercHalfWidthM;
  return bounds.Intersects(map);
}

// Made of the finer tiles below it, or enlarged where there are none.
Result<std::string> DrawTile(const storage::Tileset& tileset, const geo::TileId& tile, int side_px,
                             image::PictureFormat format) {
  SKYQUILT_TRY_ASSIGN(image::RgbaImage pixels, RenderWindow(tileset, WindowOfTile(tile, side_px)));
  return EncodeTile(std::move(pixels), format);
}

Error TooLargeToDouble() {
  return {ErrorCode::kNotFound, "The tiles of this map are so large that there are none of twice the size."};
}

Result<Response> DoubleTile(Service& service, const Request& request, const storage::Tileset& tileset,
                            const TileRequest& wanted) {
  const int side_px = 2 * TileSizePx(tileset);
  if (side_px > image::kMaxPictureSidePx) return TooLargeToDouble();
  const image::PictureFormat format = wanted.format.value_or(image::PictureFormat::kPng);
  return AnswerMade(service, request, tileset,
                    {tileset.flight_id, tileset.revision.revision, wanted.tile, format, 2}, "2x",
                    [&] { return DrawTile(tileset, wanted.tile, side_px, format); });
}

// The format in Accept, where the address has none: an exact image type, or else as stored.
std::optional<image::PictureFormat> FormatByAccept(const Request& request) {
  const std::string_view accept = request.headers.Find("Accept");
  for (const image::PictureFormatRow& row : image::kPictureFormats) {
    if (EqualsIgnoringCase(accept, row.content_type)) return row.format;
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
  // Stored tiles that are WebP are to be PNG.
  bool is_without_webp = false;
};

// Nothing where the stored bytes are of no known format: they are sent as they are.
std::optional<image::PictureFormat> SentFormat(const TileRequest& wanted, const ShownTiles& shown,
                                               std::optional<image::PictureFormat> stored) {
  if (!stored) return std::nullopt;
  if (wanted.format) return wanted.format;
  return shown.is_without_webp && stored == image::PictureFormat::kWebp ? image::PictureFormat::kPng : stored;
}

// The format asked for is part of the tag: the same content has other bytes in another format.
const char* VariantOf(const TileRequest& wanted, const ShownTiles& shown) {
  if (wanted.format) return image::ExtensionOf(*wanted.format);
  return shown.is_without_webp ? "nowebp" : "";
}

// A stored tile or a part of it, as it is or in the format asked for.
Result<Response> Stored(Service& service, const Request& request, const TileRequest& wanted,
                        storage::FoundTile found, const ShownTiles& shown, const TileCut& cut) {
  const bool is_part = shown.depth > 0;
  std::string variant = is_part ? fmt::format("{}-{}-{}", cut.side_px, cut.left_px, cut.top_px) : "";
  variant += VariantOf(wanted, shown);
  Response response = TaggedHead(request, shown.cache_control, StrongEtag(found.content_id, variant));
  if (response.status == 304) return response;
  SKYQUILT_TRY_ASSIGN(std::string bytes,
                      found.bytes ? *std::move(found.bytes) : shown.source.Load(std::move(found)));
  const std::optional<image::PictureFormat> stored = image::PictureFormatOf(bytes);
  const std::optional<image::PictureFormat> sent = SentFormat(wanted, shown, stored);
  if (!is_part && sent == stored) {
    response.headers.Add("Content-Type", stored ? image::ContentTypeOf(*stored) : "application/octet-stream");
    response.body = std::move(bytes);
    return response;
  }
  const image::PictureFormat format = sent.value_or(image::PictureFormat::kPng);
  const auto make = [&] { return is_part ? CutTile(bytes, cut, format) : TranscodeTile(bytes, format); };
  if (shown.tileset != nullptr) {
    const storage::MadeTileKey key{
        shown.tileset->flight_id, shown.tileset->revision.revision, wanted.tile, format, 1,
        is_part ? cut.side_px : 0};
    SKYQUILT_TRY_ASSIGN(const auto made, Made(service, request, key, make));
    if (made == nullptr) return DeferTo(Work::kCompute);
    response.body = made->bytes;
  } else {
    if (request.work < Work::kCompute) return DeferTo(Work::kCompute);
    SKYQUILT_TRY_ASSIGN(response.body, make());
  }
  // A part may show nothing.
  if (response.body.empty()) return BlankAnswer(request, wanted.empty, cut.side_px, shown.cache_control);
  response.headers.Add("Content-Type", image::ContentTypeOf(format));
  return response;
}

// An index of what a tile shows, computed from it and kept in colours.
Result<Response> IndexTile(Service& service, const Request& request, const storage::Tileset& tileset,
                           const TileRequest& wanted, int side_px) {
  if (side_px > image::kMaxPictureSidePx) return TooLargeToDouble();
  const IndexLook& look = *wanted.look;
  const image::PictureFormat format = wanted.format.value_or(image::PictureFormat::kPng);
  storage::MadeTileKey key{tileset.flight_id, tileset.revision.revision, wanted.tile, format, 1, side_px};
  key.look = look.Query();
  return AnswerMade(service, request, tileset, key, "index", [&]() -> Result<std::string> {
    SKYQUILT_TRY_ASSIGN(const IndexValues values,
                        ValuesOfTile(service.bands, tileset, look.expression, wanted.tile, side_px));
    return EncodeTile(Coloured(values, look), format);
  });
}

// Of a zoom that the map does not have.
Result<Response> TileOfOtherZoom(Service& service, const Request& request, const storage::Tileset& tileset,
                                 const TileRequest& wanted, int side_px) {
  if (wanted.look) return IndexTile(service, request, tileset, wanted, side_px);
  const image::PictureFormat format = wanted.format.value_or(image::PictureFormat::kPng);
  return AnswerMade(service, request, tileset,
                    {tileset.flight_id, tileset.revision.revision, wanted.tile, format, 1, side_px}, "zoom",
                    [&] { return DrawTile(tileset, wanted.tile, side_px, format); });
}

Result<Response> AnswerFrom(const ShownTiles& shown, Service& service, const Request& request,
                            const TileRequest& wanted) {
  // There is nothing finer to show for a preview.
  const bool is_double = wanted.is_double && shown.tileset != nullptr;
  const int side_px = (shown.side_px >> shown.depth) * (is_double ? 2 : 1);
  const int stored_zoom = wanted.tile.z() - shown.depth;
  if (shown.zooms && (stored_zoom < shown.zooms->first || stored_zoom > shown.zooms->second)) {
    if (wanted.is_of_any_zoom && shown.tileset != nullptr && Touches(wanted.tile, shown.tileset->revision))
      return TileOfOtherZoom(service, request, *shown.tileset, wanted, side_px);
    if (wanted.is_of_world && stored_zoom < shown.zooms->first) {
      return BlankAnswer(request, wanted.empty, side_px, shown.cache_control);
    }
    return Error{ErrorCode::kNotFound, fmt::format("The {} has no tiles of this zoom.", shown.name)};
  }
  const TileCut cut = CutOf(wanted.tile, shown.depth, shown.side_px);
  if (request.work < Work::kRead && !shown.source.IsAtHand(cut.stored)) return DeferTo(Work::kRead);
  SKYQUILT_TRY_ASSIGN(std::optional<storage::FoundTile> found, shown.source.Find(cut.stored));
  if (!found && wanted.look) {
    if (request.work < Work::kRead) return DeferTo(Work::kRead);
    SKYQUILT_TRY_ASSIGN(const auto bands, BoundsOfBands(service.bands, *shown.tileset));
    if (bands && bands->Intersects(wanted.tile.BoundsInMerc()))
      return IndexTile(service, request, *shown.tileset, wanted, side_px);
  }
  if (!found) {
    if (shown.tileset != nullptr && !wanted.is_of_world && !Touches(wanted.tile, shown.tileset->revision)) {
      return Error{ErrorCode::kNotFound, "This tile lies outside the map."};
    }
    return BlankAnswer(request, wanted.empty, side_px, shown.cache_control);
  }
  if (wanted.look) return IndexTile(service, request, *shown.tileset, wanted, side_px);
  if (is_double) return DoubleTile(service, request, *shown.tileset, wanted);
  return Stored(service, request, wanted, *std::move(found), shown, cut);
}

// Of the side that was asked for.
Result<Response> AnswerOfSize(ShownTiles shown, Service& service, const Request& request,
                              const TileRequest& wanted) {
  if (!wanted.side_px || *wanted.side_px == shown.side_px) return AnswerFrom(shown, service, request, wanted);
  // One of twice the side is a larger part of a stored tile, or a whole one.
  const std::optional<int> depth = CutDepth(*wanted.side_px * (wanted.is_double ? 2 : 1), shown.side_px);
  if (!depth && *wanted.side_px == kUsualTilePx) return AnswerFrom(shown, service, request, wanted);
  if (!depth) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("The tiles of this map have {} pixels, and those of {} cannot be cut from them.",
                             shown.side_px, *wanted.side_px)};
  }
  shown.depth = *depth;
  TileRequest part = wanted;
  part.is_double = false;
  return AnswerFrom(shown, service, request, part);
}

// Codes, not pictures: as they are stored, in no other size or format.
Result<Response> LayerTile(Service& service, const Request& request, const storage::Tileset& tileset,
                           const TileRequest& wanted) {
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<storage::MapTiles> reader, FindLayer(tileset, *wanted.layer));
  if (wanted.is_double || wanted.format.value_or(image::PictureFormat::kPng) != image::PictureFormat::kPng) {
    return Error{ErrorCode::kInvalidArgument,
                 "Layers are there as .png of one size: their colours are codes."};
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
    if (service.tilesets.Get(wanted.flight_id))
      return BlankAnswer(request, wanted.empty, kPreviewTileSizePx, kEnded);
    return open.error();
  }
  if (wanted.look) {
    return Error{ErrorCode::kNotFound, "A preview has no indices. Wait for the map to be finished."};
  }
  const storage::Preview& preview = (*open)->preview;
  return AnswerFrom({*(*open)->tiles, "preview", kPreviewTileSizePx,
                     std::pair(preview.min_zoom, preview.max_zoom), nullptr, kGrowing},
                    service, request, wanted);
}

Result<Response> Tile(Service& service, const Request& request, std::optional<int> side_px) {
  SKYQUILT_TRY_ASSIGN(TileNumbers numbers, ParseTileNumbers(request.Parameter("z"), request.Parameter("x"),
                                                            request.Parameter("y")));
  TileRequest wanted;
  wanted.flight_id = request.Parameter("flight");
  // Columns of a map across the antimeridian go on beyond it, for programs whose window is one range (GDAL).
  if (numbers.z <= geo::kMaxZoom && numbers.x >> numbers.z == 1 && CheckId(wanted.flight_id, "flight")) {
    const Result<std::shared_ptr<const storage::Tileset>> map = MapFor(service, request, wanted.flight_id);
    if (map && *map == nullptr) return DeferTo(Work::kRead);
    if (map && (*map)->revision.bounds.east_deg > 180.0) numbers.x -= std::int64_t{1} << numbers.z;
  }
  SKYQUILT_TRY_ASSIGN(wanted.tile, geo::TileId::Make(numbers.z, numbers.x, numbers.y));
  wanted.format = numbers.format ? numbers.format : FormatByAccept(request);
  wanted.is_double = numbers.is_double;
  wanted.side_px = side_px;
  SKYQUILT_TRY_ASSIGN(wanted.look, LookIn(request));
  // Previews are written while they are read; a flight whose map is at hand shows it.
  const bool is_quick = request.work < Work::kRead;
  if (is_quick && request.Query("rev") == kPreviewRevision) return DeferTo(Work::kRead);
  Result<Response> answer = !is_quick && ShowsPreview(service, request, wanted.flight_id)
                                ? PreviewTile(service, request, wanted)
                                : AnswerTile(service, request, wanted);
  if (answer && !numbers.format) TellByAccept(*answer);
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
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset,
                      MapFor(service, request, wanted.flight_id));
  if (tileset == nullptr) return DeferTo(Work::kRead);
  const storage::Revision& revision = tileset->revision;
  if (wanted.layer) return LayerTile(service, request, *tileset, wanted);
  ShownTiles shown{*tileset->reader,     "map",
                   TileSizePx(*tileset), std::pair(revision.min_zoom, revision.max_zoom),
                   tileset.get(),        CacheControl(request, *tileset)};
  if (wanted.format || storage::EncodingOf(tileset->reader->metadata()) != image::TileEncoding::kJpegWebp)
    return AnswerOfSize(shown, service, request, wanted);
  shown.is_without_webp = !NamesType(request.headers.Find("Accept"), "image/webp");
  Result<Response> answer = AnswerOfSize(shown, service, request, wanted);
  if (answer) TellByAccept(*answer);
  return answer;
}

void TellByAccept(Response& answer) {
  if (answer.headers.Find("Vary").empty()) answer.headers.Add("Vary", "Accept");
}

int TileSizePx(const storage::Tileset& tileset) {
  const int side_px = storage::TilesetNumber(tileset.reader->metadata(), "tile_size", 0);
  return side_px >= 64 && side_px <= 4096 ? side_px : 256;
}

Result<std::shared_ptr<storage::MapTiles>> FindLayer(const storage::Tileset& tileset,
                                                     render::MapLayer layer) {
  const auto found = tileset.layers.find(layer);
  if (found != tileset.layers.end()) return found->second;
  return Error{
      ErrorCode::kNotFound,
      fmt::format("The map was made without the layer \"{0}\". Start a job with \"layers\": [\"{0}\"].",
                  render::NameOf(layer))};
}

Result<render::MapLayer> ParseLayer(std::string_view name) {
  const std::optional<render::MapLayer> layer = render::MapLayerNamed(name);
  if (layer) return *layer;
  return Error{ErrorCode::kNotFound, "There is no such layer; there are photo, error and height."};
}

void AddTileRoutes(Router& router, Service& service) {
  router.AddQuick(Method::kGet, "/tiles/{flight}/{z}/{x}/{y}",
                  [&](const Request& request) { return Tile(service, request, std::nullopt); });
  router.AddQuick(Method::kGet, "/tiles/{flight}/256/{z}/{x}/{y}",
                  [&](const Request& request) { return Tile(service, request, kUsualTilePx); });
  router.AddQuick(
      Method::kGet, "/tiles/{flight}/{layer}/{z}/{x}/{y}", [&](const Request& request) -> Result<Response> {
        SKYQUILT_TRY_ASSIGN(const render::MapLayer layer, ParseLayer(request.Parameter("layer")));
        SKYQUILT_TRY_ASSIGN(const TilePath path, ParseTilePath(request.Parameter("z"), request.Parameter("x"),
                                                               request.Parameter("y")));
        TileRequest wanted;
        wanted.flight_id = request.Parameter("flight");
        wanted.layer = layer;
        wanted.tile = path.tile;
        wanted.format = path.format;
        wanted.is_double = path.is_double;
        return AnswerTile(service, request, wanted);
      });
}

}  // namespace skyquilt::api
