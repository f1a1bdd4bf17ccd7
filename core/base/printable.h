// Printable: text that came with the input (file names above all) as one line for a terminal: control
// characters become question marks, so that a name can neither break the line nor steer the terminal. UTF-8
// passes unchanged. Pure; any thread.
#pragma once

#include <algorithm>
#include <string>

namespace skyquilt {

inline std::string Printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, '?');
  return text;
}

}  // namespace skyquilt
