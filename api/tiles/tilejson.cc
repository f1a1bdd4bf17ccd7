#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/etag.h"
#include "api/problem.h"
#include "api/responses.h"
#include "api/tiles/tiles.h"

namespace skyquilt::api {
namespace {

std::string Document(const Request& request, const storage::Tileset& tileset, const std::string& name) {
  const storage::Revision& revision = tileset.revision;
  const auto& [west, south, east, north] = revision.bounds;
  const int center_zoom = std::max(revision.min_zoom, revision.max_zoom - 4);
  nlohmann::ordered_json document;
  document["tilejson"] = "3.0.0";
  document["name"] = name;
  document["version"] = fmt::format("{}.0.0", revision.revision);
  document["scheme"] = "xyz";
  document["tiles"] = {fmt::format("{}/tiles/{}/{{z}}/{{x}}/{{y}}?rev={}", request.base_url,
                                   tileset.flight_id, revision.revision)};
  document["bounds"] = revision.bounds;
  document["center"] = {(west + east) / 2, (south + north) / 2, center_zoom};
  document["minzoom"] = revision.min_zoom;
  document["maxzoom"] = revision.max_zoom;
  document["tileSize"] = TileSizePx(tileset);
  const auto& metadata = tileset.reader->metadata();
  for (const char* key : {"attribution", "description"}) {
    const auto found = metadata.find(key);
    if (found != metadata.end() && !found->second.empty()) document[key] = found->second;
  }
  return document.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
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
  const Result<std::shared_ptr<const storage::Tileset>> tileset = service.tilesets.Get(std::string(id));
  if (!tileset) return tileset.error();
  Response response = Text(200, Document(request, **tileset, flight->name), "application/json");
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
