// The options that the NodeODM-compatible node offers: those of OpenDroneMap under their usual names, so that
// presets and scripts made for it run, and a few of our own. Most of them have no effect here, and their help
// says so.
#pragma once

#include <span>
#include <string_view>

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
// Null for a name that is not in the list.
const NodeOption* FindNodeOption(std::string_view name);

}  // namespace skyquilt::api
