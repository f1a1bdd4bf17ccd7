// The list of subcommands.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddCommands(CLI::App& app);

}  // namespace skyquilt::server
