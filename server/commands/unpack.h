// `skyquilt unpack`: started by `serve` for an uploaded archive (server/intake/unpack_sandboxed.h). Internal.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddUnpackCommand(CLI::App& app);

}  // namespace skyquilt::server
