// `skyquilt worker`: runs the jobs of a data folder until it is stopped. `serve` starts its own workers; more
// may run beside them.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddWorkerCommand(CLI::App& app);

}  // namespace skyquilt::server
