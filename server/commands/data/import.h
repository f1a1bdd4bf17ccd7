// `skyquilt import`: a map of others as a flight of a running server, or of a data folder.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddImportCommand(CLI::App& app);

}  // namespace skyquilt::server
