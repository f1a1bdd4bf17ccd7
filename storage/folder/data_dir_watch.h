// DataDirWatch: is the data folder, with the catalogue in it, still the one that was opened? A folder that
// was removed, moved, unmounted or replaced leaves the server with an open database that no longer has a
// name: whatever is written then is lost. Compares device and inode; some stats a call, fit for every request
// that writes. Comes back by itself when the folder does. Any thread.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "storage/files/data_dir.h"

namespace skyquilt::storage {

class DataDirWatch {
 public:
  // While the catalogue is open.
  // `has_catalogue`: it lies in the folder.
  static Result<DataDirWatch> Begin(const DataDir& dir, bool has_catalogue = true);
  // kUnavailable, saying what is gone.
  Result<void> Check() const;

 private:
  struct Watched {
    std::filesystem::path path;
    dev_t device;
    ino_t inode;
    const char* what;
  };
  std::vector<Watched> watched_;
};

}  // namespace skyquilt::storage
