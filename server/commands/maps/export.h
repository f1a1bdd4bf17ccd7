// `skyquilt export`: a finished map as one file of another format, coordinate system, area or resolution.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddExportCommand(CLI::App& app);

}  // namespace skyquilt::server
