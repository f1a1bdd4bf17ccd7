// `skyquilt simulate`: writes a drone flight that never took place, with known truth.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddSimulateCommand(CLI::App& app);

}  // namespace skyquilt::server
