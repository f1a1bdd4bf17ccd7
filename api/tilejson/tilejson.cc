// TileJSON 3.0.0 of maps and layers. https://github.com/mapbox/tilejson-spec/tree/master/3.0.0 Any thread.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/auth/flight_access.h"
#include "api/common/feature_query.h"
#include "api/http/links.h"
#include "api/http/parameters.h"
#include "api/http/responses.h"
#include "api/json/json_codec.h"
#include "api/routes.h"
#include "api/surface/height_tiles.h"
#include "api/surface/map_surface.h"
#include "api/tiles/index_values.h"
#include "api/tiles/recode_tile.h"
#include "api/tiles/tile_json_place.h"
#include "api/tiles/tiles.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

struct ShownMap {
  std::string version;
  std::string revision;  // as it stands in addresses
  geo::LatLonBounds bounds;
  int min_zoom = 0;
  int max_zoom = 0;
  int tile_size_px = 256;
  std::string
      below;  // what stands between the flight and the zoom: "", a layer's name or a size, with its '/'
  std::string ending = {};      // of the row: ".png", or nothing
  std::string parameters = {};  // behind the revision: "&index=ndvi", or nothing
};

Value Document(const Request& request, const std::string& flight_id, const std::string& flight_name,
               const ShownMap& shown) {
  const int center_zoom = std::max(shown.min_zoom, shown.max_zoom - 4);
  Value document;
  document["tilejson"] = "3.0.0";
  document["name"] = flight_name;
  document["version"] = shown.version;
  document["scheme"] = "xyz";
  document["tiles"] = {
      LinkTo(request, fmt::format("/tiles/{}/{}{{z}}/{{x}}/{{y}}{}?rev={}{}", flight_id, shown.below,
                                  shown.ending, shown.revision, shown.parameters))};
  AddPlace(shown.bounds, center_zoom, document);
  document["minzoom"] = shown.min_zoom;
  document["maxzoom"] = shown.max_zoom;
  document["tileSize"] = shown.tile_size_px;
  return document;
}

Value Document(const Request& request, const storage::Flight& flight, const ShownMap& shown) {
  return Document(request, flight.id, flight.name, shown);
}

// What an index looks like, and where its legend is.
Value IndexEntry(const Request& request, const std::string& flight_id, const IndexLook& look) {
  Value entry = {{"title", look.title},
                 {"expression", look.text},
                 {"rescale", {look.least, look.most}},
                 {"colormap", look.ramp_name}};
  if (!look.name.empty()) entry["id"] = look.name;
  entry["legend"] = LinkTo(request, fmt::format("/api/v1/flights/{}/legend.svg?{}", flight_id, look.Query()));
  return entry;
}

// Which bands a map has, and the indices that can be made of them.
void AddIndices(Service& service, const Request& request, const storage::Tileset& tileset, Value& document) {
  const std::vector<std::string> bands = BandsAtHand(service.bands, tileset);
  document["bands"] = bands;
  if (service.bands.AreHere()) {  // as BandsAtHand
    const Result<std::optional<geo::Bounds2>> bounds = BoundsOfBands(service.bands, tileset);
    if (bounds && *bounds) document["bands_bounds"] = geo::LatLonBoundsFromMerc(**bounds).ToArray();
  }
  document["indices"] = Value::array();
  for (const indices::SpectralIndex* index : indices::IndicesOf(bands)) {
    Value entry = IndexEntry(request, tileset.flight_id, LookOf(*index));
    entry["tilejson"] =
        LinkTo(request, fmt::format("/tiles/{}.json?index={}", tileset.flight_id, index->name));
    document["indices"].push_back(std::move(entry));
  }
}

// By its stored tiles, or by those of 256 pixels that are cut from them.
Result<Value> MapDocument(Service& service, const Request& request, const storage::Flight& flight,
                          bool is_of_usual_tiles) {
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset, service.tilesets.Get(flight.id));
  const storage::Revision& revision = tileset->revision;
  ShownMap shown{fmt::format("{}.0.0", revision.revision),
                 std::to_string(revision.revision),
                 revision.bounds,
                 revision.min_zoom,
                 revision.max_zoom,
                 TileSizePx(*tileset),
                 ""};
  const int depth = is_of_usual_tiles ? CutDepth(kUsualTilePx, shown.tile_size_px).value_or(0) : 0;
  if (depth > 0) {
    shown.min_zoom += depth;
    shown.max_zoom += depth;
    shown.tile_size_px = kUsualTilePx;
    shown.below = fmt::format("{}/", kUsualTilePx);
  }
  SKYQUILT_TRY_ASSIGN(const std::optional<IndexLook> look, LookIn(request));
  if (look) {
    SKYQUILT_TRY(CheckBands(service.bands, *tileset, look->expression));
    SKYQUILT_TRY_ASSIGN(const auto bands, BoundsOfBands(service.bands, *tileset));
    if (bands) shown.bounds = geo::LatLonBoundsFromMerc(*bands);
    shown.ending = ".png";
    shown.parameters = "&" + look->Query();
  }
  Value document = Document(request, flight, shown);
  const auto& metadata = tileset->reader->metadata();
  for (const char* key : {"attribution", "description"}) {
    const auto found = metadata.find(key);
    if (found != metadata.end() && !found->second.empty()) document[key] = found->second;
  }
  if (look) {
    document["name"] = fmt::format("{}, {}", flight.name, look->title);
    document["index"] = IndexEntry(request, flight.id, *look);
    return document;
  }
  AddIndices(service, request, *tileset, document);
  SKYQUILT_TRY_ASSIGN(const std::vector<Surface> surfaces, service.surfaces.Of(flight.id, revision.revision));
  document["heights"] = Value::array();
  for (const Surface surface : surfaces) document["heights"].push_back(NameOf(surface));
  if (!surfaces.empty())
    document["terrain"] = LinkTo(request, fmt::format("/tiles/{}/{}.json", flight.id, kTerrainTiles));
  for (const auto& [layer, reader] : tileset->layers) {
    const char* name = render::NameOf(layer);
    document["layers"].push_back(
        {{"id", name},
         {"tilejson", LinkTo(request, fmt::format("/tiles/{}/{}.json", flight.id, name))},
         {"legends", LinkTo(request, fmt::format("/api/v1/flights/{}/layers.json", flight.id))}});
  }
  return document;
}

Result<Value> PreviewDocument(Service& service, const Request& request, const storage::Flight& flight,
                              bool is_of_usual_tiles) {
  const Result<std::shared_ptr<const storage::OpenPreview>> open = service.preview_cache.Get(flight.id);
  if (!open) {
    // Who follows the preview learns of its end a moment after it: the map has taken its place.
    return service.tilesets.Get(flight.id) ? MapDocument(service, request, flight, is_of_usual_tiles)
                                           : Result<Value>(open.error());
  }
  const storage::Preview& preview = (*open)->preview;
  Value document = Document(request, flight,
                            {fmt::format("0.{}.0", preview.edition), std::string(kPreviewRevision),
                             preview.bounds, preview.min_zoom, preview.max_zoom, kPreviewTileSizePx, ""});
  document["description"] = "Preview by recorded poses, of the photos that have arrived";
  return document;
}

Result<Value> LayerDocument(Service& service, const Request& request, const storage::Flight& flight,
                            render::MapLayer layer) {
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset, service.tilesets.Get(flight.id));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<storage::MapTiles> reader, FindLayer(*tileset, layer));
  const auto zoom = [&](const char* key, int otherwise) {
    return storage::TilesetNumber(reader->metadata(), key, otherwise);
  };
  const storage::Revision& revision = tileset->revision;
  Value document =
      Document(request, flight,
               {fmt::format("{}.0.0", revision.revision), std::to_string(revision.revision), revision.bounds,
                zoom("minzoom", revision.min_zoom), zoom("maxzoom", revision.max_zoom), render::kLayerTilePx,
                render::NameOf(layer) + std::string("/")});
  document["name"] = fmt::format("{}, {}", flight.name, render::NameOf(layer));
  if (layer == render::MapLayer::kHeight) document["encoding"] = "terrarium";
  return document;
}

// TileJSON of all maps, newest first, as tileserver-gl lists them: what a page needs to offer them.
Result<Response> TileIndex(Service& service, const Request& request) {
  constexpr int kMaxIndexed = 1000;
  SKYQUILT_TRY_ASSIGN(const int limit,
                      ParseLimit(request.Query("limit").value_or(""), kMaxIndexed, kMaxIndexed));
  SKYQUILT_TRY_ASSIGN(const auto cursor, ParseCursor(request.Query("cursor")));
  SKYQUILT_TRY_ASSIGN(const storage::MapPage page, ListVisibleMaps(service, request, limit, cursor));
  Value list = Value::array();
  for (const storage::ShownFlight& map : page.maps) {
    const Result<TileFacts> tiles = FactsOf(service, map);
    if (!tiles) continue;  // deleted meanwhile, or damaged: its own address says so
    const storage::Revision& revision = map.revision;
    list.push_back(Document(request, map.flight_id, map.name,
                            {fmt::format("{}.0.0", revision.revision), std::to_string(revision.revision),
                             revision.bounds, revision.min_zoom, revision.max_zoom, tiles->side_px, ""}));
    list.back()["id"] = map.flight_id;
    list.back()["url"] = LinkTo(request, fmt::format("/tiles/{}.json", map.flight_id));
  }
  Response response = NoCache(Text(200, JsonText(list), "application/json"));
  if (page.next_cursor) {
    const std::string next =
        LinkTo(request, fmt::format("/tiles/index.json?limit={}&cursor={}", limit, *page.next_cursor));
    response.headers.Add("Link", "<" + next + ">; rel=\"next\"");
  }
  return response;
}

// The router knows whole segments only: "{name}.json" is taken apart here.
Result<std::string> BeforeJson(std::string_view segment) {
  if (!segment.ends_with(".json"))
    return Error{ErrorCode::kNotFound, "There is nothing here. Did you mean .json?"};
  segment.remove_suffix(5);
  return std::string(segment);
}

Result<storage::Flight> FlightNamed(Service& service, const std::string& id) {
  SKYQUILT_TRY(CheckId(id, "flight"));
  return service.catalogue.GetFlight(id);
}

// Of the map (whose stored tiles have any size, the usual ones 256 pixels), or of a layer beside it.
enum class Shown : std::uint8_t { kStoredTiles, kUsualTiles, kLayer };
Result<Value> DocumentOf(Service& service, const Request& request, const storage::Flight& flight, Shown what,
                         render::MapLayer layer) {
  if (what == Shown::kLayer) return LayerDocument(service, request, flight, layer);
  const bool is_of_usual_tiles = what == Shown::kUsualTiles;
  if (ShowsPreview(service, request, flight.id))
    return PreviewDocument(service, request, flight, is_of_usual_tiles);
  return MapDocument(service, request, flight, is_of_usual_tiles);
}

Result<Response> TileJson(Service& service, const Request& request, const std::string& id, Shown what,
                          render::MapLayer layer = {}) {
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, FlightNamed(service, id));
  SKYQUILT_TRY_ASSIGN(const Value document, DocumentOf(service, request, flight, what, layer));
  return Tagged(request, NoCache(Text(200, JsonText(document), "application/json")));
}

}  // namespace

void AddTileJsonRoute(Router& router, Service& service) {
  router.Add(Method::kGet, "/tiles/index.json", On(service, TileIndex));
  router.Add(Method::kGet, "/tiles/{tileset}", [&](const Request& request) -> Result<Response> {
    SKYQUILT_TRY_ASSIGN(const std::string id, BeforeJson(request.Parameter("tileset")));
    return TileJson(service, request, id, Shown::kStoredTiles);
  });
  router.Add(Method::kGet, "/tiles/{flight}/256.json", [&](const Request& request) {
    return TileJson(service, request, request.Parameter("flight"), Shown::kUsualTiles);
  });
  router.Add(Method::kGet, "/tiles/{flight}/{tileset}", [&](const Request& request) -> Result<Response> {
    SKYQUILT_TRY_ASSIGN(const std::string name, BeforeJson(request.Parameter("tileset")));
    SKYQUILT_TRY_ASSIGN(const render::MapLayer layer, ParseLayer(name));
    return TileJson(service, request, request.Parameter("flight"), Shown::kLayer, layer);
  });
}

}  // namespace skyquilt::api
