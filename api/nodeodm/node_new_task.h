// What task/new and task/new/init have in common: the fields of a new task, whichever form they came in
// (multipart, urlencoded or JSON), checked.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "api/http/http_message.h"
#include "api/nodeodm/node_options.h"
#include "api/service.h"
#include "core/base/result.h"

namespace skyquilt::api {

// Texts by name. What JSON has as a list, an object, a number or a truth is its JSON text.
using NodeFields = std::map<std::string, std::string, std::less<>>;

// Of a field that comes twice, the first counts; files are passed over. An empty body has no fields. Errors:
// kInvalidArgument, kTooLarge.
Result<NodeFields> ParseNodeFields(std::string_view content_type, const std::string& body);

// The field's text, empty if there is none.
std::string NodeField(const NodeFields& fields, std::string_view name);

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

// One line of a task's notes, whatever characters a client's text in it has.
std::string NodeNote(std::string text);
std::vector<std::string> NodeNotes(const std::vector<std::string>& unknown_options);
std::int64_t NodeNowMs();

}  // namespace skyquilt::api
