// CheckServerAddress: the address of a running server as commands take it: slashes at its end go; what is no
// address ends the command (Fail).
#pragma once

#include <string>

namespace skyquilt::server {

void CheckServerAddress(const char* command, std::string& url);

}  // namespace skyquilt::server
