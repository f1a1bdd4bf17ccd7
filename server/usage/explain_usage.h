// WhatIsUnknown: the first word of a command line that names no command or option of the program, in a
// sentence that says which was meant and where the list is; nothing where all are known. WhatWasToBeWritten:
// the last word, where a command that writes is given no --out and nothing is there. Both asked before the
// library parses, which would complain of whatever it meets first. HelpAsOption: "help stitch" as
// "stitch --help". Any thread; but for a look whether a file is there, pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

namespace skyquilt::server {

// words: without the program's name.
std::optional<std::string> WhatIsUnknown(const CLI::App& app, const std::vector<std::string>& words);

std::optional<std::string> WhatWasToBeWritten(const CLI::App& app, const std::vector<std::string>& words);

std::vector<std::string> HelpAsOption(std::vector<std::string> words);

// Which of the known words somebody meant who typed another: the one with the fewest letters changed, left
// out, added or swapped, if those are few for its length. Source: the restricted Damerau-Levenshtein
// distance.
std::optional<std::string> NearWord(std::string_view typed, const std::vector<std::string>& known);

// The command that `words` are of: "skyquilt stitch".
std::string CommandOf(const CLI::App& app, const std::vector<std::string>& words);

}  // namespace skyquilt::server
