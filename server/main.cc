// skyquilt: one program, one subcommand a task.
#include <dlfcn.h>
#include <fmt/core.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "server/commands/commands.h"
#include "server/commands/config_file.h"
#include "server/manual/manual_command.h"
#include "server/usage/explain_usage.h"

namespace {
constexpr int kUsageError = 64;  // EX_USAGE of sysexits.h

// OpenBLAS, where a machine has it for BLAS (numpy and QGIS bring it along), begins a thread for each
// processor as it is loaded. A process with threads cannot be confined, and sums that are shared out differ
// between machines. For libraries that are loaded later and processes that are started from here the variable
// is enough.
void KeepBlasToOneThread() {
  setenv("OPENBLAS_NUM_THREADS", "1", 1);
  using SetThreads = void (*)(int);
  if (const auto set_threads =
          reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"))) {
    set_threads(1);
  }
}
}  // namespace

int main(int argc, char** argv) {
  // Where whoever started this program ignores the ends of processes, so would it: how its own ended, and
  // that they did, nobody would know.
  signal(SIGCHLD, SIG_DFL);
  KeepBlasToOneThread();
  CLI::App app{"Skyquilt: from a drone's SD card to a map in the browser"};
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("skyquilt ") + SKYQUILT_VERSION);
  skyquilt::server::AddCommands(app);
  skyquilt::server::AddManualCommands(app, SKYQUILT_VERSION);
  try {
    auto words = skyquilt::server::ExpandConfig(
        skyquilt::server::HelpAsOption(std::vector<std::string>(argv + 1, argv + argc)));
    if (!words) {
      fmt::print(stderr, "skyquilt: {}\n", words.error().message);
      return 1;
    }
    if (const auto unknown = skyquilt::server::WhatIsUnknown(app, *words)) {
      fmt::print(stderr, "{}\n", *unknown);
      return kUsageError;
    }
    if (const auto out = skyquilt::server::WhatWasToBeWritten(app, *words)) {
      fmt::print(stderr, "{}\n", *out);
      return kUsageError;
    }
    const std::string command = skyquilt::server::CommandOf(app, *words);
    app.failure_message([command](const CLI::App*, const CLI::Error& error) {
      return fmt::format("{}: {}\n\"{} --help\" explains what it takes.\n", command, error.what(), command);
    });
    std::reverse(words->begin(), words->end());  // as the library takes them
    app.parse(*std::move(words));
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    // The machine is out of something (memory, disk, threads); input errors never come this way.
    fmt::print(stderr, "skyquilt: {}\n", error.what());
    return 70;
  }
  return 0;
}
