// `skyquilt place`: a finished map that lies nowhere on Earth brought to where it belongs, without aligning
// its photos again.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddPlaceCommand(CLI::App& app);

}  // namespace skyquilt::server
