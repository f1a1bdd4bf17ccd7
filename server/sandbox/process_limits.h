// Resource limits of this process from now on, where it decodes files of users: a malicious image or archive
// then fails on a limit instead of taking the memory that serves tiles. Call once, before other threads are
// started.
#pragma once

#include <cstdint>
#include <optional>

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

// Also without core dumps: they would fill the disk with what was uploaded.
void LimitThisProcess(const ProcessLimits& limits);

// Tiles first: this process may use what is left of the CPU, and is the first to go when memory runs out.
void StepBack();

// Ends this process when its parent ends. False: `parent` has ended already.
bool FollowParent(int parent, int signal);

}  // namespace skyquilt::server
