#include "server/usage/one_of.h"

#include <CLI/CLI.hpp>
#include <algorithm>

namespace skyquilt::server {
namespace {

constexpr const char* kName = "one of";  // by which an option's validator is found again

std::string ListOf(const std::vector<std::string>& words) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i)
    list += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return list;
}

std::string NotAmong(const std::string& typed, const std::string& list) {
  return "\"" + typed + "\" is not known here; it takes " + list + ".";
}

}  // namespace

CLI::Validator OneOf(const std::vector<std::string>& words) {
  const std::string list = ListOf(words);
  return {[words, list](const std::string& typed) {
            const bool is_known = std::find(words.begin(), words.end(), typed) != words.end();
            return is_known ? std::string() : NotAmong(typed, list);
          },
          list, kName};
}

CLI::Validator OneOfNumbers(const std::vector<std::pair<std::string, long>>& values) {
  std::vector<std::string> words;
  for (const auto& [word, value] : values) words.push_back(word);
  const std::string list = ListOf(words);
  return {[values, list](std::string& typed) {
            for (const auto& [word, value] : values) {
              if (word != typed) continue;
              typed = std::to_string(value);
              return std::string();
            }
            return NotAmong(typed, list);
          },
          list, kName};
}

std::vector<std::string> WordsOf(CLI::Option& option) {
  std::string list;
  try {
    list = option.get_validator(kName)->get_description();
  } catch (const CLI::OptionNotFound&) {
    return {};
  }
  std::vector<std::string> words;
  for (std::size_t begin = 0; begin < list.size();) {
    const std::size_t comma = list.find(", ", begin);
    const std::size_t last = list.find(" or ", begin);
    const std::size_t end = std::min({comma, last, list.size()});
    words.push_back(list.substr(begin, end - begin));
    begin = end + (end == last ? 4 : 2);
  }
  return words;
}

}  // namespace skyquilt::server
