// Values that options take beyond the library's own. OneOf: one of several words, each for a value of an
// enumeration (or for itself); help shows the words in their order, another is answered by their list. The
// number goes to Option::transform, the words alone to Option::check. Length: metres, or with a unit ("0.05",
// "5cm", "5 cm", "2in"), which becomes the number of metres. RefuseNoNumbers: "nan", which lies in every
// range of the library, is refused by every option of numbers, those of commands below included. Pure; any
// thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

namespace skyquilt::server {

CLI::Validator OneOf(const std::vector<std::string>& words);
CLI::Validator OneOfNumbers(const std::vector<std::pair<std::string, long>>& values);

// The words that an option takes, for manual pages and completions; empty where any value will do.
std::vector<std::string> WordsOf(CLI::Option& option);

template <typename Value>
auto OneOf(const std::vector<std::pair<std::string, Value>>& values) {
  using Number = std::enable_if_t<std::is_enum_v<Value> || std::is_integral_v<Value>, long>;
  std::vector<std::pair<std::string, Number>> numbers;
  for (const auto& [word, value] : values) numbers.emplace_back(word, static_cast<Number>(value));
  return OneOfNumbers(numbers);
}

// In metres; nothing where the text is no length.
std::optional<double> ParseLengthM(std::string_view text);
CLI::Validator Length();

void RefuseNoNumbers(CLI::App& app);

// --gsd and --any-gsd, of every command that makes maps. Both outlive the command line.
void AddGsdOptions(CLI::App& command, std::optional<double>& gsd_m, bool& any_gsd);

}  // namespace skyquilt::server
