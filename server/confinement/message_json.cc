#include "server/confinement/message_json.h"

#include <nlohmann/json.hpp>

#include "server/confinement/message_checks.h"

namespace skyquilt::server {

std::string DumpMessage(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

int CountOf(const nlohmann::json& json) {
  const double value = json;
  return IsWithin(value, 0, kMaxPhotos) ? static_cast<int>(value) : -1;
}

}  // namespace skyquilt::server
