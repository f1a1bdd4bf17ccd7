#include "api/nodeodm/node_new_task.h"

#include <charconv>

#include "api/flights/flights.h"
#include "api/json/json_codec.h"
#include "api/nodeodm/nodeodm.h"
#include "core/base/try.h"

namespace skyquilt::api {

storage::NodeTask NewTask::Record(const std::string& flight_id) const {
  storage::NodeTask record;
  record.uuid = uuid;
  record.flight_id = flight_id;
  record.options = choice.shown;
  record.created_ms = created_ms;
  for (const std::string& note : NodeNotes(choice.unknown)) record.notes += note + "\n";
  return record;
}

Result<NewTask> NewTaskFrom(Service& service, const Request& request, const NodeFields& fields) {
  NewTask task;
  const std::string_view wanted = request.headers.Find("set-uuid");
  task.uuid = NewNodeUuid();
  if (!wanted.empty()) {
    const std::optional<std::string> uuid = NodeUuid(wanted);
    if (!uuid)
      return Error{ErrorCode::kInvalidArgument, "Invalid uuid: set-uuid must be a UUID of version 1 to 7.",
                   ""};
    const Result<storage::NodeTask> taken = service.node_tasks.Find(*uuid);
    if (taken) return Error{ErrorCode::kConflict, "Invalid uuid: it is in use.", ""};
    if (taken.error().code != ErrorCode::kNotFound) return taken.error();
    task.uuid = *uuid;
  }
  if (NodeField(fields, "zipurl") != "") {
    return Error{ErrorCode::kUnprocessable,
                 "This node fetches nothing by itself (zipurl). Upload the photos.", ""};
  }
  SKYQUILT_TRY_ASSIGN(const NodeChoice choice, ParseNodeOptions(NodeField(fields, "options")));
  task.choice = choice;
  task.name = NodeField(fields, "name");
  if (task.name.empty()) task.name = DefaultFlightName(storage::Now());
  const Result<FlightFields> checked = ParseFlightFields(JsonObject({{"name", JsonString(task.name)}}));
  if (!checked) return checked.error();
  const std::string date = NodeField(fields, "dateCreated");
  task.created_ms = NodeNowMs();
  if (!date.empty()) {
    const auto parsed = std::from_chars(date.data(), date.data() + date.size(), task.created_ms);
    if (parsed.ec != std::errc() || parsed.ptr != date.data() + date.size()) task.created_ms = NodeNowMs();
  }
  return task;
}

}  // namespace skyquilt::api
