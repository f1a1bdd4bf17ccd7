// The `compare` command: one flight by every method, as a table and a picture. See CompareMethods.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddCompareCommand(CLI::App& app);

}  // namespace skyquilt::server
