#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <vector>

#include "core/pipeline/inspect_flight.h"
#include "server/commands/commands.h"
#include "server/inputs/open_elevation_model.h"
#include "server/jobs/out_folder.h"
#include "server/terminal/fail.h"

namespace skyquilt::server {
namespace {

struct InspectArguments {
  std::vector<std::filesystem::path> inputs;
  bool as_json = false;
};

void Run(const InspectArguments& arguments) {
  const auto files = OrFail("skyquilt", FilesOfFlight(arguments.inputs));
  SilentProgress progress;
  const auto elevations = OrFail("skyquilt", OpenElevationModel("", files));
  auto verdict = OrFail("skyquilt", pipeline::InspectFlight(files, {}, progress, elevations.source.get()));
  verdict.warnings.insert(verdict.warnings.end(), elevations.warnings.begin(), elevations.warnings.end());
  fmt::print("{}", arguments.as_json ? pipeline::VerdictJson(verdict) : pipeline::VerdictText(verdict));
  if (verdict.photos_placeable == 0 && verdict.photos_by_images == 0) throw CLI::RuntimeError(2);
}

}  // namespace

void AddInspectCommand(CLI::App& app) {
  auto arguments = std::make_shared<InspectArguments>();
  CLI::App* command =
      app.add_subcommand("inspect", "Say what is in the photos and what a map of them will be and cost");
  command->add_option("IN", arguments->inputs, "Photos, logs, or folders of them")
      ->required()
      ->check(CLI::ExistingPath);
  command->add_flag("--json", arguments->as_json, "Print JSON");
  command->footer(
      "Of photos only headers are read. Ends with 2 when no photo can be placed.\n"
      "Example:\n"
      "  skyquilt inspect /media/sd/DCIM");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace skyquilt::server
