// Completions: what a shell loads so that Tab finishes commands, options, words and file names. Each is the
// text of one file of that shell. Pure; any thread.
#pragma once

#include <string>

#include "server/manual/described_command.h"

namespace skyquilt::server {

std::string BashCompletion(const DescribedCommand& program);
std::string FishCompletion(const DescribedCommand& program);
std::string ZshCompletion(const DescribedCommand& program);

}  // namespace skyquilt::server
