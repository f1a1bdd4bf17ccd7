#include "server/commands/verdict.h"

#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>

#include "server/intake/verdict_sandboxed.h"
#include "server/sandbox/sandbox.h"

namespace skyquilt::server {
namespace {

struct VerdictOptions {
  int parent = 0;
  std::int64_t cpu_s = 0;
  bool is_of_control = false;
};

}  // namespace

void AddVerdictCommand(CLI::App& app) {
  const auto options = std::make_shared<VerdictOptions>();
  CLI::App* command =
      app.add_subcommand("verdict", "Inspect the files of a flight (serve starts this by itself)");
  command->group("");  // not in the list of commands
  command->add_option("--parent", options->parent, "Stop when this process is gone")->required();
  command->add_option("--cpu-s", options->cpu_s, "Seconds of CPU it may take")->required();
  command->add_flag("--control", options->is_of_control, "Read a list of control points instead");
  command->callback([options] {
    if (!FollowParent(options->parent, SIGKILL)) return;
    if (options->is_of_control) {
      ControlHere(options->cpu_s);
    } else {
      VerdictHere(options->cpu_s);
    }
    _exit(0);  // what libraries do at the end of a process may be a call that it has no right to any more
  });
}

}  // namespace skyquilt::server
