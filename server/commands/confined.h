// `skyquilt stitch-confined` and `skyquilt preview-confined`: started by a worker to decode files of users
// (server/jobs/stitch_apart.h, server/preview/preview_apart.h). Internal.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddConfinedCommands(CLI::App& app);

}  // namespace skyquilt::server
