// LostFolder: where things go that were found in a data folder and belong to nothing there: lost/<time>/ with
// the path they had. Nothing in it is ever removed but by the operator ("skyquilt data purge-lost"). Made
// when the first thing comes. One thread at a time.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "storage/db/clock.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

class LostFolder {
 public:
  LostFolder(DataDir dir, Time now) : dir_(std::move(dir)), now_(now) {}

  // Moves something below the data folder here; a line for the log says what, why and where to. What cannot
  // be moved (it is on another disk, or not ours to move) stays where it is, and the line says so.
  std::string Take(const std::filesystem::path& path, const std::string& why);

 private:
  DataDir dir_;
  Time now_;
};

// What is in lost/, by the time it came.
struct LostItem {
  std::filesystem::path folder;  // lost/<time>
  std::int64_t files = 0;
  std::int64_t bytes = 0;
};
std::vector<LostItem> ListLost(const DataDir& dir);
// For good. Errors: kIo (something stays).
Result<void> PurgeLost(const DataDir& dir);

}  // namespace skyquilt::storage
