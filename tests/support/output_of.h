// OutputOf: what a command of the shell prints, any bytes; nothing where it cannot be run.
#pragma once

#include <cstdio>
#include <string>

namespace skyquilt::test {

inline std::string OutputOf(const std::string& command) {
  std::string output;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  char part[4096];
  for (std::size_t read = 0; (read = fread(part, 1, sizeof part, pipe)) > 0;) output.append(part, read);
  pclose(pipe);
  return output;
}

}  // namespace skyquilt::test
