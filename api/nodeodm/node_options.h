// The options of the NodeODM-compatible node: what GET /options offers, and what a client's list of {name,
// value} means to us. As the original does, names that are not known are no error (clients send presets made
// for other engines); who asks is told of them. Pure.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::api {

std::string NodeOptionsJson();

struct NodeChoice {
  std::string job_options = "{}";    // JSON as ParseJobOptions takes it
  std::string shown = "[]";          // JSON list of {name, value} of what is known
  std::vector<std::string> unknown;  // names
};

// An empty text means no choice. Errors: kUnprocessable, whose message is the JSON list of {name, error} that
// the contract asks for; kInvalidArgument (not a JSON list).
Result<NodeChoice> ParseNodeOptions(std::string_view json);

}  // namespace skyquilt::api
