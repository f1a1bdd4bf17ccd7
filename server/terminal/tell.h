// Tell: text on stderr for who watches a command. Where nobody can be told any more (the terminal is gone,
// the disk of a log full) work goes on all the same; fmt::print would throw. Any thread.
#pragma once

#include <cstdio>
#include <string>

namespace skyquilt::server {

inline void Tell(const std::string& text) { std::fputs(text.c_str(), stderr); }

}  // namespace skyquilt::server
