#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "api/etag.h"
#include "api/json_codec.h"
#include "api/problem.h"
#include "api/responses.h"
#include "api/tiles/tiles.h"

namespace skyquilt::api {
namespace {

using Value = nlohmann::ordered_json;

struct Shown {
  std::string version;
  std::string revision;  // as it stands in addresses
  std::array<double, 4> bounds{};
  int min_zoom = 0;
  int max_zoom = 0;
  int tile_size_px = 256;
};

Value Document(const Request& request, const storage::Flight& flight, const Shown& shown) {
  const auto& [west, south, east, north] = shown.bounds;
  const int center_zoom = std::max(shown.min_zoom, shown.max_zoom - 4);
  Value document;
  document["tilejson"] = "3.0.0";
  document["name"] = flight.name;
  document["version"] = shown.version;
  document["scheme"] = "xyz";
  document["tiles"] = {
      fmt::format("{}/tiles/{}/{{z}}/{{x}}/{{y}}?rev={}", request.base_url, flight.id, shown.revision)};
  document["bounds"] = shown.bounds;
  document["center"] = {(west + east) / 2, (south + north) / 2, center_zoom};
  document["minzoom"] = shown.min_zoom;
  document["maxzoom"] = shown.max_zoom;
  document["tileSize"] = shown.tile_size_px;
  return document;
}

Result<Value> PreviewDocument(Service& service, const Request& request, const storage::Flight& flight) {
  const Result<std::shared_ptr<const storage::OpenPreview>> open = service.preview_cache.Get(flight.id);
  if (!open) return open.error();
  const storage::Preview& preview = (*open)->preview;
  Value document = Document(request, flight,
                            {fmt::format("0.{}.0", preview.edition), std::string(kPreviewRevision),
                             preview.bounds, preview.min_zoom, preview.max_zoom, kPreviewTileSizePx});
  document["description"] = "Preview by recorded poses, of the photos that have arrived";
  return document;
}

Result<Value> MapDocument(Service& service, const Request& request, const storage::Flight& flight) {
  const Result<std::shared_ptr<const storage::Tileset>> tileset = service.tilesets.Get(flight.id);
  if (!tileset) return tileset.error();
  const storage::Revision& revision = (*tileset)->revision;
  Value document = Document(request, flight,
                            {fmt::format("{}.0.0", revision.revision), std::to_string(revision.revision),
                             revision.bounds, revision.min_zoom, revision.max_zoom, TileSizePx(**tileset)});
  const auto& metadata = (*tileset)->reader->metadata();
  for (const char* key : {"attribution", "description"}) {
    const auto found = metadata.find(key);
    if (found != metadata.end() && !found->second.empty()) document[key] = found->second;
  }
  return document;
}

Result<Response> TileJson(Service& service, const Request& request) {
  // The router knows whole segments only: "{id}.json" is taken apart here.
  std::string_view id = request.Parameter("tileset");
  if (!id.ends_with(".json"))
    return Error{ErrorCode::kNotFound, "There is nothing here. Did you mean .json?", ""};
  id.remove_suffix(5);
  const Result<void> checked = CheckId(std::string(id), "flight");
  if (!checked) return checked.error();
  const Result<storage::Flight> flight = service.catalogue.GetFlight(std::string(id));
  if (!flight) return flight.error();
  const Result<Value> document = ShowsPreview(service, request, flight->id)
                                     ? PreviewDocument(service, request, *flight)
                                     : MapDocument(service, request, *flight);
  if (!document) return document.error();
  Response response =
      Text(200, document->dump(-1, ' ', false, Value::error_handler_t::replace), "application/json");
  response.headers.Add("Cache-Control", "no-cache");
  const std::string etag = StrongEtag(std::hash<std::string>()(response.body));
  response.headers.Add("ETag", etag);
  if (EtagListMatches(request.headers.Find("If-None-Match"), etag)) {
    response.status = 304;
    response.body.clear();
  }
  return response;
}

}  // namespace

void AddTileJsonRoute(Router& router, Service& service) {
  router.Add(Method::kGet, "/tiles/{tileset}", [&](const Request& request) {
    Result<Response> answer = TileJson(service, request);
    Response response = answer ? *std::move(answer) : Problem(answer.error(), request);
    response.headers.Add("Access-Control-Allow-Origin", "*");
    return response;
  });
}

}  // namespace skyquilt::api
