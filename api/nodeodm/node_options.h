// The options of the NodeODM-compatible node: what GET /options offers, and what a client's list of {name,
// value} means to us. As the original does, names that are not known are no error (clients send presets made
// for other engines); who asks is told of them. Most of those that are known, OpenDroneMap's under their
// usual names, have no effect here, and their help says so. Pure.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::api {

enum class NodeOptionEffect {
  kJob,      // becomes `job_option`
  kArchive,  // chooses what all.zip holds
  kNone,     // is taken and changes nothing
};

struct NodeOption {
  const char* name;
  const char* type;    // bool, int, float, string or enum
  const char* value;   // the default, always a text
  const char* domain;  // a text, or for an enum a JSON list
  const char* help;
  NodeOptionEffect effect = NodeOptionEffect::kNone;
  const char* job_option = "";
};

// The default of archive-tiles.
inline constexpr const char* kUsualArchiveTiles = "mbtiles";

std::span<const NodeOption> NodeOptionList();

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
