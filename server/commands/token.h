// `skyquilt token`: who may use a server: add, list, revoke. Works on the data folder, also while a server
// runs.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddTokenCommand(CLI::App& app);

}  // namespace skyquilt::server
