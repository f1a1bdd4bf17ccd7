// One file of the user's: the name he gave it and where its bytes are. A value; any thread.
#pragma once

#include <filesystem>
#include <string>

namespace skyquilt::flight {

struct InputFile {
  std::string name;
  std::filesystem::path path;
};

}  // namespace skyquilt::flight
