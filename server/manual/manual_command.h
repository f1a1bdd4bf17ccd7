// The commands "man" and "completion": manual pages and shell completions of the program itself, for packages
// and for who installs from source.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace skyquilt::server {

// `app` outlives the parsing; commands that are added to it later are described too.
void AddManualCommands(CLI::App& app, const std::string& version);

}  // namespace skyquilt::server
