// `skyquilt locate`: which photos of a finished map see a place, and where a photo's pixel lies.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddLocateCommand(CLI::App& app);

}  // namespace skyquilt::server
