// `skyquilt inspect IN...`: what these photos and logs contain and what to expect from stitching them.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddInspectCommand(CLI::App& app);

}  // namespace skyquilt::server
