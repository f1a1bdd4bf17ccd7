#include "server/commands/commands.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "server/commands/config_file.h"
#include "server/manual/manual_command.h"
#include "server/terminal/tell.h"
#include "server/usage/explain_usage.h"
#include "server/usage/option_values.h"

namespace skyquilt::server {
namespace {

constexpr int kUsageError = 64;  // EX_USAGE of sysexits.h

constexpr void (*kCommands[])(CLI::App&) = {
    AddStitchCommand,   AddServeCommand,  AddUploadCommand,  AddWatchCommand,
    AddLocateCommand,   AddPlaceCommand,  AddExportCommand,  AddReportCommand,
    AddValidateCommand, AddImportCommand, AddInspectCommand, AddSimulateCommand,
    AddTokenCommand,    AddDataCommand,   AddWorkerCommand,  AddSandboxedCommands};

int RunCommand(int argc, const char* const* argv) {
  CLI::App app{"Skyquilt: from a drone's SD card to a map in the browser"};
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("skyquilt ") + SKYQUILT_VERSION);
  for (const auto add : kCommands) add(app);
  RefuseNoNumbers(app);
  AddManualCommands(app, SKYQUILT_VERSION);
  try {
    auto words = ExpandConfig(HelpAsOption(std::vector<std::string>(argv + 1, argv + argc)));
    if (!words) {
      fmt::print(stderr, "skyquilt: {}\n", words.error().message);
      return 1;
    }
    if (const auto unknown = WhatIsUnknown(app, *words)) {
      fmt::print(stderr, "{}\n", *unknown);
      return kUsageError;
    }
    if (const auto out = WhatWasToBeWritten(app, *words)) {
      fmt::print(stderr, "{}\n", *out);
      return kUsageError;
    }
    const std::string command = CommandOf(app, *words);
    app.failure_message([command](const CLI::App*, const CLI::Error& error) {
      return fmt::format("{}: {}\n\"{} --help\" explains what it takes.\n", command, error.what(), command);
    });
    std::reverse(words->begin(), words->end());  // as the library takes them
    app.parse(*std::move(words));
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    // The machine is out of something (memory, disk, threads); input errors never come this way.
    Tell(fmt::format("skyquilt: {}\n", error.what()));
    return 70;
  }
  return 0;
}

}  // namespace

int RunCommandLine(int argc, const char* const* argv) {
  const int code = RunCommand(argc, argv);
  // What was printed may have waited until now to be written. Who closed stdout wants none of it.
  const bool is_written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (is_written || fcntl(STDOUT_FILENO, F_GETFD) < 0) return code;
  Tell("skyquilt: what it printed could not all be written; the disk may be full.\n");
  return code == 0 ? 1 : code;
}

}  // namespace skyquilt::server
