// `skyquilt worker`: runs the jobs of a data folder until it is told to stop. `serve` starts its own; more
// may run.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddWorkerCommand(CLI::App& app);

}  // namespace skyquilt::server
