// `skyquilt stitch-sandboxed`, `preview-sandboxed` and `export-sandboxed`: started by a worker to decode
// files of users (server/jobs/stitch_sandboxed.h, server/preview/preview_sandboxed.h). Internal.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddSandboxedCommands(CLI::App& app);

}  // namespace skyquilt::server
