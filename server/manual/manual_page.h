// ManualPage: a page of section 1 for the program, or for one of its commands with those below it, as man(7)
// has it. Pure; any thread. `day` is the date at its foot, as 2026-11-23.
#pragma once

#include <string>

#include "server/manual/described_command.h"

namespace skyquilt::server {

// "skyquilt", or "skyquilt-stitch".
std::string NameOfManualPage(const DescribedCommand& command);

std::string ManualPage(const DescribedCommand& command, const DescribedCommand& program,
                       const std::string& version, const std::string& day);

}  // namespace skyquilt::server
