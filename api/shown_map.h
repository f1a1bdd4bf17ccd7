// FindShownMap: the map that a flight shows, as blobs and as a folder of files. A revision that is being
// retired may be gone when it is opened: the caller then looks it up again. Any thread. Errors: kNotFound (no
// such flight, or it has no map yet) and the catalogue's.
#pragma once

#include <cstdint>
#include <string>

#include "api/service.h"

namespace skyquilt::api {

struct ShownMap {
  std::string flight_name;
  std::int64_t revision = 0;
  std::string prefix;  // of its blobs: "flights/<id>/r7/"
};
Result<ShownMap> FindShownMap(Service& service, const std::string& flight_id);

// One of its products as a file, fetched where maps lie elsewhere. kNotFound: it has none of this name.
Result<storage::LocalBlob> FetchProduct(Service& service, const ShownMap& map, const std::string& name);

}  // namespace skyquilt::api
