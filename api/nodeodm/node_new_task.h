// NewTaskFrom: what task/new and task/new/init have in common: the fields of a new task, checked.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "api/http/http_message.h"
#include "api/nodeodm/node_fields.h"
#include "api/nodeodm/node_options.h"
#include "api/service.h"

namespace skyquilt::api {

struct NewTask {
  std::string uuid;
  std::string name;
  NodeChoice choice;
  std::int64_t created_ms = 0;
  std::string webhook;             // empty: nobody is told
  std::string outputs = "[]";      // JSON list of paths
  std::vector<std::string> notes;  // for its client

  // As the catalogue has it, not committed.
  storage::NodeTask Record(const std::string& flight_id) const;
};

// Errors: kInvalidArgument, kUnprocessable, kConflict (the UUID is in use), with the contract's texts.
Result<NewTask> NewTaskFrom(Service& service, const Request& request, const NodeFields& fields);

}  // namespace skyquilt::api
