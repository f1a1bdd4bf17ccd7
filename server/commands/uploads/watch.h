// `skyquilt watch DIR... --server URL`: cards and hot folders become flights as they fill.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddWatchCommand(CLI::App& app);

}  // namespace skyquilt::server
