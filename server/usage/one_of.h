// OneOf: an option that takes one of several words, each for a value of an enumeration (or for itself). Help
// shows the words; another is answered by their list. Included where commands are declared.
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace skyquilt::server {

inline std::string ListOf(const std::vector<std::string>& words) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i)
    list += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return list;
}

inline CLI::Validator OneOf(const std::vector<std::string>& words) {
  return {[words](const std::string& typed) {
            if (std::find(words.begin(), words.end(), typed) != words.end()) return std::string();
            return "\"" + typed + "\" is not known here; it takes " + ListOf(words) + ".";
          },
          ListOf(words)};
}

// For Option::transform, in the order in which help is to list them.
template <typename Value>
CLI::Validator OneOf(const std::vector<std::pair<std::string, Value>>& values) {
  std::vector<std::string> words;
  for (const auto& [word, value] : values) words.push_back(word);
  return {[values, words](std::string& typed) {
            for (const auto& [word, value] : values) {
              if (word != typed) continue;
              typed = std::to_string(static_cast<long>(value));
              return std::string();
            }
            return "\"" + typed + "\" is not known here; it takes " + ListOf(words) + ".";
          },
          ListOf(words)};
}

}  // namespace skyquilt::server
