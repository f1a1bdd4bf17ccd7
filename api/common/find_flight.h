// A flight by the id that a request names, and the map that it shows, as blobs and as a folder of files. A
// revision that is being retired may be gone when it is opened: the caller then looks it up again. Any
// thread. Errors: kNotFound (no such flight, it is in the trash, or it has no map yet) and the catalogue's.
#pragma once

#include <cstdint>
#include <string>

#include "api/service.h"

namespace skyquilt::api {

// Its id is checked first: one that could be none is not looked for.
Result<void> RequireFlight(Service& service, const std::string& id);

struct ShownMap {
  std::string flight_name;
  std::int64_t revision = 0;
  std::string prefix;  // of its blobs: "flights/<id>/r7/"
};
Result<ShownMap> FindShownMap(Service& service, const std::string& flight_id);

// One of its products as a file, fetched where maps lie elsewhere. kNotFound: it has none of this name.
Result<storage::LocalBlob> FetchProduct(Service& service, const ShownMap& map, const std::string& name);
// The media type of a map's GeoTIFF.
inline constexpr const char* kCogType = "image/tiff; application=geotiff; profile=cloud-optimized";

}  // namespace skyquilt::api
