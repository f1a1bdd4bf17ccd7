#include "server/commands/commands.h"

#include "server/commands/data/data.h"
#include "server/commands/data/import.h"
#include "server/commands/maps/export.h"
#include "server/commands/maps/inspect.h"
#include "server/commands/maps/locate.h"
#include "server/commands/maps/place.h"
#include "server/commands/maps/report.h"
#include "server/commands/maps/simulate.h"
#include "server/commands/maps/stitch.h"
#include "server/commands/maps/validate.h"
#include "server/commands/sandboxed.h"
#include "server/commands/serve.h"
#include "server/commands/token.h"
#include "server/commands/unpack.h"
#include "server/commands/uploads/upload.h"
#include "server/commands/uploads/watch.h"
#include "server/commands/verdict.h"
#include "server/commands/worker.h"

namespace skyquilt::server {

void AddCommands(CLI::App& app) {
  AddStitchCommand(app);
  AddServeCommand(app);
  AddUploadCommand(app);
  AddWatchCommand(app);
  AddLocateCommand(app);
  AddPlaceCommand(app);
  AddExportCommand(app);
  AddReportCommand(app);
  AddValidateCommand(app);
  AddImportCommand(app);
  AddInspectCommand(app);
  AddSimulateCommand(app);
  AddTokenCommand(app);
  AddDataCommand(app);
  AddUnpackCommand(app);
  AddVerdictCommand(app);
  AddWorkerCommand(app);
  AddSandboxedCommands(app);
}

}  // namespace skyquilt::server
