// The flight of a folder, for benches: what cannot be read ends the program.
#pragma once

#include <fmt/core.h>

#include <cstdlib>

#include "core/flight/read_flight.h"

namespace skyquilt {

inline flight::Flight ReadFolder(const char* folder, Progress& progress) {
  const Result<std::vector<flight::InputFile>> files = flight::ListInputFiles({folder});
  Result<flight::Flight> read = files ? flight::ReadFlight(*files, 0, progress) : files.error();
  if (!read) {
    fmt::print(stderr, "{}\n", read.error().message);
    std::exit(1);
  }
  return *std::move(read);
}

}  // namespace skyquilt
