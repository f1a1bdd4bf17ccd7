// StacItem: a map as a STAC 1.0 item: where it is, when its photos were taken, and every way to have it; and
// the addresses of the catalogue that it belongs to. Any thread.
// https://github.com/radiantearth/stac-spec/blob/v1.0.0/item-spec/item-spec.md
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "api/http/http_message.h"
#include "api/surface/map_surface.h"
#include "storage/catalogue/catalogue.h"

namespace skyquilt::api {

// "ID-r3": another revision is another item.
std::string StacItemId(const storage::ShownFlight& map);
// `surfaces`: the heights that the map has beside it.
nlohmann::ordered_json StacItem(const Request& request, const storage::ShownFlight& map,
                                const std::vector<Surface>& surfaces);

}  // namespace skyquilt::api
