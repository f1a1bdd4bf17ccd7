// `skyquilt serve`: the web page, the API and the tiles over one data folder, with worker processes beside
// it.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddServeCommand(CLI::App& app);

}  // namespace skyquilt::server
