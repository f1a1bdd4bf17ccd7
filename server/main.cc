// skyquilt: one program, one subcommand a task.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <exception>

#include "server/commands/commands.h"

int main(int argc, char** argv) {
  CLI::App app{"Skyquilt: from a drone's SD card to a map in the browser"};
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("skyquilt ") + SKYQUILT_VERSION);
  skyquilt::server::AddCommands(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    // The machine is out of something (memory, disk, threads); input errors never come this way.
    fmt::print(stderr, "skyquilt: {}\n", error.what());
    return 70;
  }
  return 0;
}
