#include "server/commands/commands.h"

#include "server/commands/stitch.h"

namespace skyquilt::server {

void AddCommands(CLI::App& app) {
  AddStitchCommand(app);
}

}  // namespace skyquilt::server
