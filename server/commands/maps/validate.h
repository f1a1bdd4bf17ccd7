// `skyquilt validate MAP`: whether a map, of ours or of anybody, is sound.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddValidateCommand(CLI::App& app);

}  // namespace skyquilt::server
