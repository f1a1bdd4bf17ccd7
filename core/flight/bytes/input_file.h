// One file of the user's: the name he gave it and where its bytes are. A value; any thread.
// kMapNotesName: the file among them that holds what was noted on the map, of which no map is made.
#pragma once

#include <filesystem>
#include <string>

namespace skyquilt::flight {

inline constexpr const char* kMapNotesName = "map_notes.geojson";

struct InputFile {
  std::string name;
  std::filesystem::path path;
};

}  // namespace skyquilt::flight
