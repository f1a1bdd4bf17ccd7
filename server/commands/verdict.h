// `skyquilt verdict`: what `serve` starts for the verdict on a flight's files
// (server/intake/verdict_apart.h). Not for hands.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddVerdictCommand(CLI::App& app);

}  // namespace skyquilt::server
