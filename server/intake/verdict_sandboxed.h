// VerdictSandboxed: inspects a flight's files (core/pipeline/inspect_flight.h) in a process of its own
// (server/sandbox/run_sandboxed.h), because their parsers read files of users. Blocking; any thread. Errors:
// those of the inspection, kUnprocessable where it exceeded its limits, kUnavailable.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"

namespace skyquilt::server {

// `options`: the flight's, as JSON. Answers the verdict as JSON.
Result<std::string> VerdictSandboxed(const std::vector<flight::InputFile>& files, const std::string& options);

// What that process does: reads the files' names and the options from standard input, and tells its parent.
// `cpu_s`: what it may take.
void VerdictHere(std::int64_t cpu_s);

}  // namespace skyquilt::server
