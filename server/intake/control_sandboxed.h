// ControlSandboxed: reads a list of surveyed points (core/flight/logs/texts/gcp_list.h) in a process of its
// own (server/sandbox/run_sandboxed.h), because a user may have written it. Blocking; any thread. Errors:
// those of the reader, kUnprocessable where it exceeded its limits, kUnavailable.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace skyquilt::server {

// Answers the points as the API's JSON (core/pipeline/placing/control_points.h).
Result<std::string> ControlSandboxed(const std::filesystem::path& list);

// What that process does: reads the list's path from standard input, and tells its parent.
// `cpu_s`: what it may take.
void ControlHere(std::int64_t cpu_s);

}  // namespace skyquilt::server
