// `skyquilt verdict`: started by `serve` to inspect a flight's files (server/intake/verdict_sandboxed.h).
// Internal.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddVerdictCommand(CLI::App& app);

}  // namespace skyquilt::server
