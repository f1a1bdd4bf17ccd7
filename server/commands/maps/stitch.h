// `skyquilt stitch IN... -o DIR`: a folder in, a map out, without a server.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddStitchCommand(CLI::App& app);

}  // namespace skyquilt::server
