// SpawnSelf: starts another process of this binary, and SpawnOther one of another program, with no signal
// blocked or ignored, whatever this process does with its own, and none of its descriptors but what is named
// here. Any thread; but the kernel signals a child when the thread that started it ends. Error: kUnavailable.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::server {

// What of the environment goes along. Keys of stores and databases (AWS_..., PG...) are for who speaks to
// them: whoever decodes the files of others could write them into what it makes.
enum class Secrets { kKept, kWithheld };

// `words`: what follows the program's name. `stdout_fd`, `stdin_fd`: what its standard output and input
// become, where given.
Result<pid_t> SpawnSelf(std::vector<std::string> words, Secrets secrets,
                        std::optional<int> stdout_fd = std::nullopt,
                        std::optional<int> stdin_fd = std::nullopt);

// Of another program: with this environment alone, in a process group of its own, nothing to read and nowhere
// to write to but `log_fd`, as its standard error.
Result<pid_t> SpawnOther(const std::string& program, std::vector<std::string> words,
                         std::vector<std::string> environment, int log_fd);

// "by signal 9 (Killed)", "with code 1": of a status that waitpid gave.
std::string HowItEnded(int wait_status);

}  // namespace skyquilt::server
