#include "server/commands/config_file.h"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>

#include "core/base/try.h"
#include "core/flight/bytes/text_fields.h"

namespace skyquilt::server {
namespace {

std::string Unquoted(std::string_view text) {
  const bool is_quoted =
      text.size() >= 2 && (text.front() == '"' || text.front() == '\'') && text.back() == text.front();
  return std::string(is_quoted ? text.substr(1, text.size() - 2) : text);
}

Result<std::vector<std::string>> WordsOf(const std::string& path) {
  std::ifstream file(path);
  if (!file)
    return Error{
        ErrorCode::kNotFound,
        fmt::format("The configuration file {} cannot be opened. Check the path given with --config.", path)};
  std::vector<std::string> words;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::string_view text = flight::Trim(line);
    if (text.empty() || text.front() == '#') continue;
    const std::size_t equals = text.find('=');
    const std::string name(flight::Trim(text.substr(0, equals)));
    const bool is_name = !name.empty() && name != "config" &&
                         name.find_first_not_of("abcdefghijklmnopqrstuvwxyz-") == std::string::npos;
    if (equals == std::string::npos || !is_name) {
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format("{} line {}: it must be \"name = value\", with an option of serve as the name.", path,
                      number)};
    }
    if (std::getenv(VariableOf(name).c_str()) != nullptr) continue;
    words.push_back(fmt::format("--{}={}", name, Unquoted(flight::Trim(text.substr(equals + 1)))));
  }
  return words;
}

}  // namespace

std::string VariableOf(std::string_view option) {
  std::string name = "SKYQUILT_SERVE_";
  for (const char c : option) name.push_back(c == '-' ? '_' : static_cast<char>(c - 'a' + 'A'));
  return name;
}

Result<std::vector<std::string>> ExpandConfig(std::vector<std::string> words) {
  if (words.empty() || words.front() != "serve") return words;
  for (std::size_t i = 1; i < words.size(); ++i) {
    std::string path;
    constexpr std::string_view kJoined = "--config=";
    if (words[i] == "--config" && i + 1 < words.size()) path = words[i + 1];
    if (words[i].starts_with(kJoined)) path = words[i].substr(kJoined.size());
    if (path.empty()) continue;
    SKYQUILT_TRY_ASSIGN(const std::vector<std::string> from_file, WordsOf(path));
    words.insert(words.begin() + 1, from_file.begin(), from_file.end());
    return words;
  }
  return words;
}

}  // namespace skyquilt::server
