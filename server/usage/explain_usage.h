// WhatIsUnknown: the first word of a command line that names no command or option of the program, in a
// sentence that says which was meant and where the list is; nothing where all are known. Asked before the
// library parses, which would complain of whatever it meets first. SayWhatIsWrong: how the library's own
// complaints are told. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace skyquilt::server {

// words: without the program's name.
std::optional<std::string> WhatIsUnknown(const CLI::App& app, const std::vector<std::string>& words);

// The command that `words` are of: "skyquilt stitch".
std::string CommandOf(const CLI::App& app, const std::vector<std::string>& words);

}  // namespace skyquilt::server
