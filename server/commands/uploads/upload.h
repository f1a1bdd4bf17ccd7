// `skyquilt upload`: files to a running server, and the map made of them.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddUploadCommand(CLI::App& app);

}  // namespace skyquilt::server
