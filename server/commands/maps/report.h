// `skyquilt report`: a finished map on one printable HTML page.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddReportCommand(CLI::App& app);

}  // namespace skyquilt::server
