#include "server/usage/explain_usage.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <system_error>

namespace skyquilt::server {
namespace {

constexpr std::size_t kLongestWord = 64;  // of what is compared: an argument may have any length

std::size_t Distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> of(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) of[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) of[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      of[i][j] =
          std::min({of[i - 1][j] + 1, of[i][j - 1] + 1, of[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        of[i][j] = std::min(of[i][j], of[i - 2][j - 2] + 1);
    }
  }
  return of[a.size()][b.size()];
}

constexpr std::size_t kMaxShown = 60;  // letters of what was typed

std::string Shown(std::string_view typed) {
  std::string shown;
  for (const char letter : typed.substr(0, kMaxShown))
    shown += static_cast<unsigned char>(letter) < 0x20 || letter == 0x7f ? '?' : letter;
  return typed.size() > kMaxShown ? shown + "..." : shown;
}

std::string Meant(const std::optional<std::string>& word) {
  return word ? fmt::format(" Did you mean {}?", *word) : "";
}

// Those that help lists; what the program starts by itself is no suggestion.
std::vector<std::string> NamesOfCommands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (!command->get_group().empty()) names.push_back(command->get_name());
  }
  return names;
}

bool HasOption(const CLI::App& app, const std::string& name) {
  if (name == "--help" || name == "--help-all" || name == "--version") return true;
  return app.get_option_no_throw(name) != nullptr;
}

std::vector<std::string> NamesOfOptions(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    const std::vector<std::string>& long_names = option->get_lnames();
    names.insert(names.end(), long_names.begin(), long_names.end());
  }
  return names;
}

const CLI::App* CommandNamed(const CLI::App& app, const std::string& name) {
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == name) return command;
  }
  return nullptr;
}

struct Reached {
  const CLI::App* command;
  std::string name;                    // "skyquilt token add"
  std::size_t words = 0;               // that were commands, and those before them
  std::optional<std::string> unknown;  // where a command was to come
};

Reached Follow(const CLI::App& app, const std::vector<std::string>& words) {
  Reached reached{&app, "skyquilt", 0, std::nullopt};
  for (std::size_t i = 0; i < words.size() && reached.command->get_require_subcommand_min() > 0; ++i) {
    if (words[i].starts_with('-')) continue;
    const CLI::App* next = CommandNamed(*reached.command, words[i]);
    if (next == nullptr) {
      reached.unknown = words[i];
      break;
    }
    reached.command = next;
    reached.name += " " + words[i];
    reached.words = i + 1;
  }
  return reached;
}

}  // namespace

std::optional<std::string> NearWord(std::string_view typed, const std::vector<std::string>& known) {
  if (typed.empty() || typed.size() > kLongestWord) return std::nullopt;
  std::optional<std::string> nearest;
  std::size_t least = 0;
  for (const std::string& word : known) {
    const bool is_begun = (typed.size() > 2 && word.starts_with(typed)) ||  // cut short, or more than that
                          (word.size() > 2 && typed.starts_with(word));
    const std::size_t distance = is_begun ? 1 : Distance(typed, word);
    if (nearest && distance >= least) continue;
    nearest = word;
    least = distance;
  }
  if (!nearest || least > std::max<std::size_t>(1, nearest->size() / 3)) return std::nullopt;
  return nearest;
}

std::string CommandOf(const CLI::App& app, const std::vector<std::string>& words) {
  return Follow(app, words).name;
}

std::optional<std::string> WhatIsUnknown(const CLI::App& app, const std::vector<std::string>& words) {
  const Reached reached = Follow(app, words);
  if (reached.unknown) {
    const std::optional<std::string> near = NearWord(*reached.unknown, NamesOfCommands(*reached.command));
    return fmt::format("{} has no command \"{}\".{} \"{} --help\" lists them.", reached.name,
                       Shown(*reached.unknown), near ? Meant(reached.name + " " + *near) : "", reached.name);
  }
  for (std::size_t i = reached.words; i < words.size() && words[i] != "--"; ++i) {
    if (!words[i].starts_with("--")) continue;
    const std::string name = words[i].substr(0, words[i].find('='));
    if (HasOption(*reached.command, name)) continue;
    const std::optional<std::string> near = NearWord(name.substr(2), NamesOfOptions(*reached.command));
    return fmt::format("{} has no option {}.{} \"{} --help\" explains all it has.", reached.name, Shown(name),
                       near ? Meant("--" + *near) : "", reached.name);
  }
  return std::nullopt;
}

std::optional<std::string> WhatWasToBeWritten(const CLI::App& app, const std::vector<std::string>& words) {
  const Reached reached = Follow(app, words);
  const CLI::Option* out = reached.command->get_option_no_throw("--out");
  if (reached.unknown || out == nullptr || !out->get_required() || words.size() < reached.words + 2)
    return std::nullopt;
  const auto of_command = words.begin() + static_cast<std::ptrdiff_t>(reached.words);
  const bool says_out = std::any_of(of_command, words.end(), [](const std::string& word) {
    return word.starts_with("--out") || (word.starts_with("-o") && !word.starts_with("--"));
  });
  // The last word may be the value of an option before it.
  if (says_out || words.back().starts_with('-') || words[words.size() - 2].starts_with('-'))
    return std::nullopt;
  std::error_code none;  // what cannot be looked at is there
  if (std::filesystem::exists(words.back(), none) || none) return std::nullopt;
  return fmt::format(
      "{}: there is nothing at {}. If that is what to write, say -o {}. \"{} --help\" explains what it takes.",
      reached.name, Shown(words.back()), Shown(words.back()), reached.name);
}

std::vector<std::string> HelpAsOption(std::vector<std::string> words) {
  if (words.empty() || words.front() != "help") return words;
  words.erase(words.begin());
  words.emplace_back("--help");
  return words;
}

}  // namespace skyquilt::server
