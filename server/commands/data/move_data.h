// "skyquilt data move": photos and maps of a stopped server from its folder to S3, or back.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

// `data`: the command that it becomes a part of.
void AddMoveCommand(CLI::App& data);

}  // namespace skyquilt::server
