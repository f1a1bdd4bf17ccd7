// Parsers of files of users, each run in a process of its own (server/sandbox/run_sandboxed.h): the
// inspection of a flight's files (core/pipeline/inspect_flight.h), and the reading of a list of surveyed
// points (core/flight/logs/texts/gcp_list.h). Blocking; any thread. Errors: those of the inspection or
// reader, kUnprocessable where it exceeded its limits, kUnavailable.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"

namespace skyquilt::server {

// `options`: the flight's, as JSON. Answers the verdict as JSON.
Result<std::string> VerdictSandboxed(const std::vector<flight::InputFile>& files, const std::string& options);

// Answers the points as the API's JSON (core/pipeline/placing/control_points.h).
Result<std::string> ControlSandboxed(const std::filesystem::path& list);

// What those processes do. The exit code.
int VerdictInSandbox(int parent);
int ControlInSandbox(int parent);

}  // namespace skyquilt::server
