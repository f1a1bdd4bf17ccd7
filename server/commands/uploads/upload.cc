#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <vector>

#include "core/base/text/printable.h"
#include "server/commands/arguments.h"
#include "server/commands/commands.h"
#include "server/jobs/out_folder.h"
#include "server/terminal/fail.h"
#include "storage/tags/flight_tags.h"

namespace skyquilt::server {
namespace {

constexpr const char* kCommandName = "skyquilt upload";

struct UploadArguments {
  std::vector<std::filesystem::path> inputs;
  UploadOptions options;
  int patience_s = 600;
  bool no_map = false, no_wait = false;
};

void Run(UploadArguments& arguments) {
  UploadOptions& options = arguments.options;
  const auto files = OrFail(kCommandName, FilesOfFlight(arguments.inputs));
  if (options.name.empty()) options.name = NameOfInput(arguments.inputs.front());
  options.server.patience = std::chrono::seconds(arguments.patience_s);
  options.makes_map = !arguments.no_map;
  CheckServerAddress(kCommandName, options.server.url);
  const auto tags = storage::CheckedTags(options.tags);
  if (!tags) Refuse(kCommandName, "--tag: " + tags.error().message);
  options.waits = !arguments.no_wait;
  const UploadedFlight uploaded = UploadAtTerminal(kCommandName, files, options);
  fmt::print("{} sent", Counted(uploaded.sent, "file"));
  if (uploaded.skipped > 0) fmt::print(", {} there", Counted(uploaded.skipped, "was", "were"));
  fmt::print("\n{}/#/flights/{}\n", options.server.url, uploaded.flight_id);
  for (const auto& [own, there] : uploaded.beside) {
    fmt::print(stderr,
               "Another {0} is there, and both count: this one is {1}. If it corrects the other, delete that "
               "(DELETE /api/v1/flights/{2}/files/{0}) and have the map made again.\n",
               Printable(own), Printable(there), uploaded.flight_id);
  }
}

}  // namespace

void AddUploadCommand(CLI::App& app) {
  const auto arguments = std::make_shared<UploadArguments>();
  CLI::App* command = app.add_subcommand("upload", "Send a flight to a running server and wait for its map");
  command->add_option("IN", arguments->inputs, "Photos, logs, films; files or folders")
      ->required()
      ->check(CLI::ExistingPath);
  arguments->options.server.url = "http://127.0.0.1:8080";
  command->add_option("--server", arguments->options.server.url, "Address of the server")
      ->capture_default_str();
  command->add_option("--token", arguments->options.server.token, "Token, where the server asks for one")
      ->envname("SKYQUILT_TOKEN");
  command->add_option("--name", arguments->options.name, "Name of the flight (default: that of the folder)");
  command
      ->add_option("--tag", arguments->options.tags,
                   "Word by which a new flight is found again; may be given several times")
      ->allow_extra_args(false);
  command->add_flag("--keep", arguments->options.is_kept,
                    "A new flight is to be kept: \"serve --keep-days\" never puts it into the trash");
  command->add_option("--flight", arguments->options.flight_id,
                      "Id of a flight that is there: what it lacks is sent");
  command
      ->add_option("--patience", arguments->patience_s,
                   "Seconds that a server which does not answer is asked again")
      ->check(CLI::Range(0, 86'400))
      ->capture_default_str();
  command->add_flag("--no-map", arguments->no_map, "Send the files and make no map yet");
  command->add_flag("--no-wait", arguments->no_wait, "End when the files are sent and the map is queued");
  command->footer(
      "\nExample:\n"
      "  skyquilt upload /media/card/DCIM --server http://maps.example:8080 --name \"Field 7\"");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace skyquilt::server
