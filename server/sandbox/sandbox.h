// What a process may do and take that decodes files of users (EnterSandbox): it may read the files it was
// given and what the system's libraries need (shared objects, PROJ's and GDAL's data), write below the
// folders it was given, and compute within its limits; no sockets, no other programs or processes.
// Irrevocable, and so done before the first byte of theirs is read and before a second thread is started: a
// kernel confines the thread that asks and those it starts. Landlock restricts files where the kernel has it,
// seccomp the system calls everywhere (server/sandbox/system_calls.h). Error: kUnavailable; the process must
// then end.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::server {

struct ProcessLimits {
  // Address space beyond what the program has now.
  std::optional<std::int64_t> more_memory_bytes = std::nullopt;
  // Memory that can be written, beyond what the program has now: heaps and stacks, but not files that are
  // mapped to be read.
  std::optional<std::int64_t> more_data_bytes = std::nullopt;
  // CPU seconds beyond those used.
  std::optional<std::int64_t> more_cpu_s = std::nullopt;
  // Of any one file.
  std::optional<std::int64_t> file_bytes = std::nullopt;
};

// Everything not listed is refused with EACCES (EXDEV for a move), whatever the rights of the process's user.
// What is not there is passed over.
struct FileAccess {
  std::vector<std::filesystem::path> reads = {};  // files, and folders with all that is below them
  // Folders: files and folders below are made, changed and removed.
  std::vector<std::filesystem::path> writes = {};
};

struct SandboxNeeds {
  ProcessLimits limits = {};
  FileAccess files = {};
  std::string_view library = {};  // the one that is loaded late and that it needs; empty: all of them
};

// The one place where a process gives up rights, its rank before others too.
Result<void> EnterSandbox(SandboxNeeds needs);

// The parts of it. Resource limits from now on: a malicious image or archive then fails on one of them
// instead of taking the memory that serves tiles. Also without core dumps: they would fill the disk with what
// was uploaded. Once, before other threads are started.
void LimitThisProcess(const ProcessLimits& limits);
Result<void> Confine(FileAccess access);

// For people and logs: "seccomp and Landlock 7", or that the latter is missing.
std::string ConfinementHere();
// Landlock's version; 0: the kernel has none, or too old a one (before Linux 5.19 nothing could be moved from
// one folder to another), or something around this process forbids its use. Files are not confined then.
int LandlockVersion();

// Tiles first: this process may use what is left of the CPU, and is the first to go when memory runs out.
void StepBack();

// Ends this process when its parent ends. False: `parent` has ended already.
bool FollowParent(int parent, int signal);

}  // namespace skyquilt::server
