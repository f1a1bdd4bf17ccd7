// ListedMaps: the maps that one capabilities document or list is of: that of one flight, or the newest that a
// request may read. No tileset stays open for it. Any thread. Errors: kInvalidArgument (a cursor that is
// none), kNotFound (the flight), and the catalogue's.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/service.h"
#include "api/tiles/tile_facts.h"
#include "api/views/map_view.h"

namespace skyquilt::api {

struct ListedMap {
  std::string layer;  // by which the document names it: "map" where there is one, else the flight's id
  storage::ShownFlight shown;
  TileFacts tiles;
};

struct ListedMaps {
  static constexpr int kMaxMaps = 1000;  // in one document

  std::string path;  // below the service's own: "/ID", or nothing
  std::string title;
  std::vector<ListedMap> maps;
  std::optional<std::string> next_cursor;  // where there are more
  std::string base_url;
  std::string token;  // as MapView's

  // What the document says of maps that it leaves out; empty where it has all.
  std::string Note() const;
  std::string Link(std::string_view path) const;
};

// Of the flight that the address names, else of all: the newest, or those older than the parameter "cursor".
Result<ListedMaps> ListMapsOf(Service& service, const Request& request);
// Whatever is not an operation of WMS or WMTS, nothing above all: people paste addresses without parameters,
// and programs add those of the service that they take it for. What the path is answers.
bool AsksForCapabilities(std::string_view operation);
// The flight that a layer of this address means. kNotFound: there is no such layer, or not for this request.
Result<std::string> FlightOfLayer(const Request& request, std::string_view layer);

}  // namespace skyquilt::api
