#include "server/commands/commands.h"

#include "server/usage/option_values.h"

namespace skyquilt::server {
namespace {

constexpr void (*kCommands[])(CLI::App&) = {
    AddStitchCommand,   AddServeCommand,  AddUploadCommand,  AddWatchCommand,
    AddLocateCommand,   AddPlaceCommand,  AddExportCommand,  AddReportCommand,
    AddValidateCommand, AddImportCommand, AddInspectCommand, AddSimulateCommand,
    AddTokenCommand,    AddDataCommand,   AddWorkerCommand,  AddSandboxedCommands};

}  // namespace

void AddCommands(CLI::App& app) {
  for (const auto add : kCommands) add(app);
  RefuseNoNumbers(app);
}

}  // namespace skyquilt::server
