#include "api/views/listed_maps.h"

#include <fmt/format.h>

#include <algorithm>

#include "api/auth/flight_access.h"
#include "api/http/links.h"
#include "api/http/parameters.h"
#include "core/base/try.h"
#include "storage/db/ids.h"

namespace skyquilt::api {
namespace {

constexpr const char* kOnlyLayer = "map";

const std::string* FlightInAddress(const Request& request) {
  const auto found = std::find_if(request.parameters.begin(), request.parameters.end(),
                                  [](const auto& parameter) { return parameter.first == "flight"; });
  return found == request.parameters.end() ? nullptr : &found->second;
}

}  // namespace

std::string ListedMaps::Note() const {
  if (!next_cursor) return "";
  return fmt::format("The {} newest maps. Older ones: the same address with cursor={}", maps.size(),
                     *next_cursor);
}

std::string ListedMaps::Link(std::string_view below) const { return WithToken(base_url, below, token); }

Result<ListedMaps> ListMapsOf(Service& service, const Request& request) {
  ListedMaps listed;
  listed.base_url = request.base_url;
  listed.token = TokenInQuery(request);
  if (const std::string* flight_id = FlightInAddress(request)) {
    SKYQUILT_TRY_ASSIGN(const MapView map, FindMap(service, request, *flight_id));
    listed.path = "/" + map.id;
    listed.title = map.name;
    listed.maps.push_back({kOnlyLayer, map.shown(), FactsOf(service, *map.tileset)});
    return listed;
  }
  listed.title = "Skyquilt";
  SKYQUILT_TRY_ASSIGN(const auto cursor, ParseCursor(Parameter(request, "cursor")));
  SKYQUILT_TRY_ASSIGN(storage::MapPage page, ListVisibleMaps(service, request, ListedMaps::kMaxMaps, cursor));
  listed.next_cursor = page.next_cursor;
  for (storage::ShownFlight& shown : page.maps) {
    const Result<TileFacts> tiles = FactsOf(service, shown);
    if (!tiles) continue;  // deleted meanwhile, or damaged: its own address says so
    std::string layer = shown.flight_id;
    listed.maps.push_back({std::move(layer), std::move(shown), *tiles});
  }
  return listed;
}

bool AsksForCapabilities(std::string_view operation) {
  constexpr std::string_view kOthers[] = {"GetMap",       "map",           "GetFeatureInfo",
                                          "feature_info", "DescribeLayer", "GetLegendGraphic",
                                          "GetStyles",    "PutStyles",     "GetTile"};
  return std::none_of(std::begin(kOthers), std::end(kOthers),
                      [&](std::string_view other) { return EqualsIgnoringCase(operation, other); });
}

Result<std::string> FlightOfLayer(const Request& request, std::string_view layer) {
  const auto missing = [](std::string why) { return Error{ErrorCode::kNotFound, std::move(why)}; };
  if (const std::string* flight_id = FlightInAddress(request)) {
    if (layer == kOnlyLayer) return *flight_id;
    return missing("The only layer is \"map\".");
  }
  const bool is_for_all = request.only_flight.empty() || layer == request.only_flight;
  if (!storage::IsId(layer) || !is_for_all)
    return missing("There is no such layer. Layers are named by the ids of flights.");
  return std::string(layer);
}

}  // namespace skyquilt::api
