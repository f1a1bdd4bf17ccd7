// `skyquilt reckon LOG [PHOTOS]`: displacement and rotation between captures from raw inertial samples,
// beside the record.
#pragma once

namespace CLI {
class App;
}

namespace skyquilt::server {

void AddReckonCommand(CLI::App& app);

}  // namespace skyquilt::server
