#include "server/commands/sandboxed.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "server/exports/export_sandboxed.h"
#include "server/jobs/stitch_sandboxed.h"
#include "server/preview/preview_sandboxed.h"

namespace skyquilt::server {
namespace {

void Add(CLI::App& app, const char* name, const char* what, int (*run)(int parent)) {
  const auto parent = std::make_shared<int>(0);
  CLI::App* command = app.add_subcommand(name, what);
  command->group("");  // not in the list of commands
  command->add_option("--parent", *parent, "Stop when this process is gone")->required();
  // All has been said: what libraries do at the end of a process is not worth a call that is refused.
  command->callback([parent, run] { _exit(run(*parent)); });
}

}  // namespace

void AddSandboxedCommands(CLI::App& app) {
  Add(app, "stitch-sandboxed", "Make the map of a job (a worker starts this by itself)", StitchInSandbox);
  Add(app, "preview-sandboxed", "Draw the preview of a flight (a worker starts this by itself)",
      PreviewInSandbox);
  Add(app, "export-sandboxed", "Make an export of a map (serve starts this by itself)", ExportInSandbox);
}

}  // namespace skyquilt::server
