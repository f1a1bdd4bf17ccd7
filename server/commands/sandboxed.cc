// The commands that this program starts by itself to decode files of users. What libraries do at the end of a
// process may be a call that it has no right to any more: each ends by _exit.
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>

#include "server/commands/commands.h"
#include "server/exports/export_sandboxed.h"
#include "server/intake/unpack_sandboxed.h"
#include "server/intake/verdict_sandboxed.h"
#include "server/jobs/stitch_sandboxed.h"
#include "server/preview/preview_sandboxed.h"
#include "server/sandbox/sandbox.h"

namespace skyquilt::server {
namespace {

struct UnpackOptions {
  std::string archive;
  std::string staging;
  std::string flight;
  int parent = 0;
  std::int64_t max_bytes = std::numeric_limits<std::int64_t>::max();
};

struct VerdictOptions {
  int parent = 0;
  std::int64_t cpu_s = 0;
  bool is_of_control = false;
};

CLI::App* AddHidden(CLI::App& app, const char* name, const char* what) {
  CLI::App* command = app.add_subcommand(name, what);
  command->group("");  // not in the list of commands
  return command;
}

// `parent` outlives the command line.
void AddParent(CLI::App& command, int& parent) {
  command.add_option("--parent", parent, "Stop when this process is gone")->required();
}

void AddUnpack(CLI::App& app) {
  const auto options = std::make_shared<UnpackOptions>();
  CLI::App* command = AddHidden(app, "unpack", "Unpack an uploaded archive (serve starts this by itself)");
  command->add_option("ARCHIVE", options->archive)->required();
  command->add_option("--staging", options->staging, "Folder to unpack into")->required();
  command->add_option("--flight", options->flight, "Whose files they will be")->required();
  AddParent(*command, options->parent);
  command->add_option("--most-bytes", options->max_bytes, "Bytes that there is room for");
  command->callback([options] {
    if (!FollowParent(options->parent, SIGKILL)) return;
    UnpackHere(options->staging, options->flight, options->archive, options->max_bytes);
    _exit(0);
  });
}

void AddVerdict(CLI::App& app) {
  const auto options = std::make_shared<VerdictOptions>();
  CLI::App* command =
      AddHidden(app, "verdict", "Inspect the files of a flight (serve starts this by itself)");
  AddParent(*command, options->parent);
  command->add_option("--cpu-s", options->cpu_s, "Seconds of CPU it may take")->required();
  command->add_flag("--control", options->is_of_control, "Read a list of control points instead");
  command->callback([options] {
    if (!FollowParent(options->parent, SIGKILL)) return;
    if (options->is_of_control) {
      ControlHere(options->cpu_s);
    } else {
      VerdictHere(options->cpu_s);
    }
    _exit(0);
  });
}

// One that is told its task by its parent (SandboxedChild).
void AddTalking(CLI::App& app, const char* name, const char* what, int (*run)(int parent)) {
  const auto parent = std::make_shared<int>(0);
  CLI::App* command = AddHidden(app, name, what);
  AddParent(*command, *parent);
  command->callback([parent, run] { _exit(run(*parent)); });
}

}  // namespace

void AddSandboxedCommands(CLI::App& app) {
  AddUnpack(app);
  AddVerdict(app);
  AddTalking(app, "stitch-sandboxed", "Make the map of a job (a worker starts this by itself)",
             StitchInSandbox);
  AddTalking(app, "preview-sandboxed", "Draw the preview of a flight (a worker starts this by itself)",
             PreviewInSandbox);
  AddTalking(app, "export-sandboxed", "Make an export of a map (serve starts this by itself)",
             ExportInSandbox);
}

}  // namespace skyquilt::server
