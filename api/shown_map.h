// FindShownMap: the map that a flight shows, as a folder of files. A revision that is being retired may be
// gone when it is opened: the caller then looks it up again. Any thread. Errors: kNotFound (no such flight,
// or it has no map yet) and the catalogue's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "api/service.h"

namespace skyquilt::api {

struct ShownMap {
  std::string flight_name;
  std::int64_t revision = 0;
  std::filesystem::path folder;
};
Result<ShownMap> FindShownMap(Service& service, const std::string& flight_id);

}  // namespace skyquilt::api
