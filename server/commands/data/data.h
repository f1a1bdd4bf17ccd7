// The `data` command: checks, repairs and cleans the data folder of a server that is stopped.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddDataCommand(CLI::App& app);

}  // namespace skyquilt::server
