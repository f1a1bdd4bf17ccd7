// Printable: text that came with the input (file names above all) as one line for a terminal: control
// characters become question marks, so that a name can neither break the line nor steer the terminal. UTF-8
// passes unchanged. Counted: a number with the word for what is counted. Pure; any thread.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace skyquilt {

inline std::string Printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, '?');
  return text;
}

// "1 file", "2 files"; `many` where that is not the word with an s.
template <typename Number>
std::string Counted(Number count, std::string_view one, std::string_view many = {}) {
  std::string text = std::to_string(count) + ' ';
  if (count == Number{1}) return text.append(one);
  return many.empty() ? text.append(one) + 's' : text.append(many);
}

}  // namespace skyquilt
