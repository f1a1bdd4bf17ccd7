// `skyquilt inspect IN...`: what is in these photos and logs and what will happen, before anyone waits.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddInspectCommand(CLI::App& app);

}  // namespace skyquilt::server
