// `skyquilt stitch IN... -o DIR`: makes the map of a folder of photos, without a server.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddStitchCommand(CLI::App& app);

}  // namespace skyquilt::server
