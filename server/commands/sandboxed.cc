// The commands that this program starts by itself to decode files of users
// (server/sandbox/sandboxed_child.h). What libraries do at the end of a process may be a call that it has no
// right to any more: each ends by _exit.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "server/commands/commands.h"
#include "server/exports/export_sandboxed.h"
#include "server/intake/unpack_sandboxed.h"
#include "server/intake/verdict_sandboxed.h"
#include "server/jobs/stitch_sandboxed.h"
#include "server/preview/preview_sandboxed.h"

namespace skyquilt::server {
namespace {

struct SandboxedCommand {
  const char* name;
  const char* what;
  int (*run)(int parent);
};

constexpr SandboxedCommand kSandboxedCommands[] = {
    {"unpack", "Unpack an uploaded archive (serve starts this by itself)", UnpackInSandbox},
    {"verdict", "Inspect the files of a flight (serve starts this by itself)", VerdictInSandbox},
    {"control", "Read a list of control points (serve starts this by itself)", ControlInSandbox},
    {"stitch-sandboxed", "Make the map of a job (a worker starts this by itself)", StitchInSandbox},
    {"preview-sandboxed", "Draw the preview of a flight (a worker starts this by itself)", PreviewInSandbox},
    {"export-sandboxed", "Make an export of a map (serve starts this by itself)", ExportInSandbox}};

}  // namespace

void AddSandboxedCommands(CLI::App& app) {
  for (const SandboxedCommand& one : kSandboxedCommands) {
    const auto parent = std::make_shared<int>(0);
    CLI::App* command = app.add_subcommand(one.name, one.what);
    command->group("");  // not in the list of commands
    command->add_option("--parent", *parent, "Stop when this process is gone")->required();
    command->callback([parent, run = one.run] { _exit(run(*parent)); });
  }
}

}  // namespace skyquilt::server
