// The cameras and the ground of a map, by which photos and places find each other. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "api/service.h"
#include "core/pipeline/report/locate.h"

namespace skyquilt::api {

// The cameras and the ground that the map of a flight was made with. Errors: kNotFound (no such flight, no
// map, or one without them), kCorrupt, kIo.
Result<pipeline::LocatedMap> ReadLocatedMap(Service& service, const std::string& flight_id);

// How a photo sees a place.
nlohmann::ordered_json SightingJson(const pipeline::Sighting& sighting);

}  // namespace skyquilt::api
