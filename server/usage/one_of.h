// OneOf: an option that takes one of several words, each for a value of an enumeration (or for itself). Help
// shows the words; another is answered by their list; WordsOf has them for manual pages and completions. The
// number goes to Option::transform, the words alone to Option::check, in the order in which help is to list
// them. Pure; any thread.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace CLI {
class Option;
class Validator;
}  // namespace CLI

namespace skyquilt::server {

CLI::Validator OneOf(const std::vector<std::string>& words);
CLI::Validator OneOfNumbers(const std::vector<std::pair<std::string, long>>& values);

// The words that an option takes; empty where any value will do.
std::vector<std::string> WordsOf(CLI::Option& option);

template <typename Value>
auto OneOf(const std::vector<std::pair<std::string, Value>>& values) {
  std::vector<std::pair<std::string, long>> numbers;
  for (const auto& [word, value] : values) numbers.emplace_back(word, static_cast<long>(value));
  return OneOfNumbers(numbers);
}

}  // namespace skyquilt::server
