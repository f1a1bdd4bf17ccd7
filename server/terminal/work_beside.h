// Commands that write one file: whether it may be written, and a folder for what is put down meanwhile. Both
// end the command where they cannot be (Fail).
#pragma once

#include <filesystem>

#include "core/base/scoped_folder.h"

namespace skyquilt::server {

// Not a folder, in a folder that is there, and not there already unless it may be replaced.
void CheckOutFile(const char* program, const std::filesystem::path& out, bool may_replace);

// Beside the file, on the same disk, under a hidden name of this process; gone at the end.
class WorkBeside {
 public:
  WorkBeside(const char* program, const std::filesystem::path& out);
  const std::filesystem::path& path() const { return folder_.path(); }

 private:
  ScopedFolder folder_;
};

}  // namespace skyquilt::server
