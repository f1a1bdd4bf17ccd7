// ExportSandboxed: has an export made by a sandboxed process (server/sandbox/sandbox.h) and watches it:
// memory, processor time, clock, and the room on the disk. Whatever becomes of that process, this one goes
// on. Blocking; one thread. Errors: those of storage::ExportMap; kCancelled (`go_on` said so), kTimeout,
// kOutOfSpace, kUnprocessable (it died, or took too much memory), kUnavailable, kIo (its folder is gone).
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "core/base/result.h"
#include "server/jobs/child_messages.h"

namespace skyquilt::server {

struct ExportLimits {
  std::chrono::seconds wall{std::chrono::hours(1)};
  std::int64_t memory_bytes = std::int64_t{1536} << 20;
  std::int64_t keep_free_bytes = std::int64_t{512} << 20;  // on the disk, for everything else
};

// `go_on`: asked some times a second, with the fraction done, 0..1. `task` without its limits, which follow
// from `limits`. The bytes of the file that is there then.
Result<std::int64_t> ExportSandboxed(ExportTask task, const ExportLimits& limits,
                                     const std::function<bool(double fraction)>& go_on);

// What that process does.
int ExportInSandbox(int parent);

// Room for everything on the disk of a folder. Error: kIo (the folder is gone).
Result<std::int64_t> FreeBytes(const std::filesystem::path& folder);

}  // namespace skyquilt::server
