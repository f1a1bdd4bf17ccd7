#include "api/common/find_flight.h"

#include "api/http/responses.h"
#include "core/base/try.h"

namespace skyquilt::api {

Result<void> RequireFlight(Service& service, const std::string& id) {
  SKYQUILT_TRY(CheckId(id, "flight"));
  SKYQUILT_TRY_ASSIGN(const bool known, service.catalogue.HasFlight(id));
  if (!known) return Error{ErrorCode::kNotFound, "There is no flight " + id + "."};
  return {};
}

Result<ShownMap> FindShownMap(Service& service, const std::string& flight_id) {
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY_ASSIGN(const storage::Flight flight, service.catalogue.GetFlight(flight_id));
  if (!flight.active_revision) {
    return Error{ErrorCode::kNotFound, "This flight has no map yet. Wait for its job to finish."};
  }
  return ShownMap{flight.name, *flight.active_revision,
                  storage::RevisionPrefix(flight_id, *flight.active_revision)};
}

Result<storage::LocalBlob> FetchProduct(Service& service, const ShownMap& map, const std::string& name) {
  return service.store.blobs().Local(map.prefix + name);
}

}  // namespace skyquilt::api
