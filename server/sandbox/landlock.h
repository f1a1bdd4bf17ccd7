// Which files this process, and every thread it starts from now on, may still open: Linux's Landlock.
// Everything not listed is refused with EACCES (EXDEV for a move), whatever the rights of the process's user.
// Irrevocable. Call before other threads are started: the kernel confines the calling thread and those it
// starts.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::server {

struct FileAccess {
  std::vector<std::filesystem::path> reads;  // files, and folders with all that is below them
  std::vector<std::filesystem::path>
      writes;  // folders: files and folders below are made, changed and removed
};

// The kernel's version of it; 0: it has none, or too old a one (before Linux 5.19 nothing could be moved from
// one folder to another), or something around this process forbids its use.
int LandlockVersion();

// What is not there is passed over. Does nothing where LandlockVersion() is 0. Error: kUnavailable.
Result<void> ConfineFiles(const FileAccess& access);

}  // namespace skyquilt::server
