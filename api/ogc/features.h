// OGC API - Features (part 1) of a map's photos: "FLIGHT.photos", where the cameras were (points), and
// "FLIGHT.footprints", what each photo shows (polygons). Read from the map's photos.geojson, filtered by box
// and time, page by page. OGC 17-069r4. Any thread.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "api/service.h"

namespace skyquilt::api {

enum class PhotoFeatures { kPhotos, kFootprints };
inline constexpr PhotoFeatures kPhotoFeatures[] = {PhotoFeatures::kPhotos, PhotoFeatures::kFootprints};

// The collection of a name as "ID.photos"; absent: it is the map itself, or nothing that we have.
std::optional<PhotoFeatures> PhotoFeaturesNamed(std::string_view collection);
// "ID.photos".
std::string NameOfCollection(const std::string& flight_id, PhotoFeatures kind);
// Its description.
nlohmann::ordered_json PhotoCollection(const Request& request, const storage::ShownFlight& map,
                                       PhotoFeatures kind);

}  // namespace skyquilt::api
