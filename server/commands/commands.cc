#include "server/commands/commands.h"

#include "server/commands/inspect.h"
#include "server/commands/simulate.h"
#include "server/commands/stitch.h"

namespace skyquilt::server {

void AddCommands(CLI::App& app) {
  AddStitchCommand(app);
  AddInspectCommand(app);
  AddSimulateCommand(app);
}

}  // namespace skyquilt::server
