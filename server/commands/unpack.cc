#include "server/commands/unpack.h"

#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>

#include "server/intake/unpack_sandboxed.h"
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

}  // namespace

void AddUnpackCommand(CLI::App& app) {
  const auto options = std::make_shared<UnpackOptions>();
  CLI::App* command =
      app.add_subcommand("unpack", "Unpack an uploaded archive (serve starts this by itself)");
  command->group("");  // not in the list of commands
  command->add_option("ARCHIVE", options->archive)->required();
  command->add_option("--staging", options->staging, "Folder to unpack into")->required();
  command->add_option("--flight", options->flight, "Whose files they will be")->required();
  command->add_option("--parent", options->parent, "Stop when this process is gone")->required();
  command->add_option("--most-bytes", options->max_bytes, "Bytes that there is room for");
  command->callback([options] {
    if (!FollowParent(options->parent, SIGKILL)) return;
    UnpackHere(options->staging, options->flight, options->archive, options->max_bytes);
    _exit(0);  // what libraries do at the end of a process may be a call that it has no right to any more
  });
}

}  // namespace skyquilt::server
