// `skyquilt stitch-confined` and `skyquilt preview-confined`: what a worker starts to read what others made
// (server/jobs/stitch_apart.h, server/preview/preview_apart.h). Not for hands.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddConfinedCommands(CLI::App& app);

}  // namespace skyquilt::server
