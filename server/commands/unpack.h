// `skyquilt unpack`: what `serve` starts for an uploaded archive (server/intake/unpack_apart.h). Not for
// hands.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddUnpackCommand(CLI::App& app);

}  // namespace skyquilt::server
