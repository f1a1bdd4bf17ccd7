// skyquilt: one program, one subcommand a task.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "server/commands/commands.h"
#include "server/commands/config_file.h"

int main(int argc, char** argv) {
  CLI::App app{"Skyquilt: from a drone's SD card to a map in the browser"};
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("skyquilt ") + SKYQUILT_VERSION);
  skyquilt::server::AddCommands(app);
  try {
    auto words = skyquilt::server::ExpandConfig(std::vector<std::string>(argv + 1, argv + argc));
    if (!words) {
      fmt::print(stderr, "skyquilt: {}\n", words.error().message);
      return 1;
    }
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
