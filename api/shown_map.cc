#include "api/shown_map.h"

#include "api/http/responses.h"

namespace skyquilt::api {

Result<ShownMap> FindShownMap(Service& service, const std::string& flight_id) {
  const Result<void> checked = CheckId(flight_id, "flight");
  if (!checked) return checked.error();
  const Result<storage::Flight> flight = service.catalogue.GetFlight(flight_id);
  if (!flight) return flight.error();
  if (!flight->active_revision) {
    return Error{ErrorCode::kNotFound, "This flight has no map yet. Wait for its job to finish.", ""};
  }
  return ShownMap{flight->name, *flight->active_revision,
                  service.store.dir().Revision(flight_id, *flight->active_revision)};
}

}  // namespace skyquilt::api
