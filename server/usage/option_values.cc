#include "server/usage/option_values.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>

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

constexpr std::pair<std::string_view, double> kUnits[] = {{"", 1.0},     {"m", 1.0},     {"cm", 0.01},
                                                          {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};

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

std::optional<double> ParseLengthM(std::string_view text) {
  double number = 0.0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  if (parsed.ec != std::errc() || !std::isfinite(number)) return std::nullopt;
  std::string_view unit = text.substr(static_cast<std::size_t>(parsed.ptr - text.data()));
  if (unit.starts_with(' ')) unit.remove_prefix(1);
  for (const auto& [name, metres] : kUnits) {
    if (unit == name) return number * metres;
  }
  return std::nullopt;
}

CLI::Validator Length() {
  return {[](std::string& typed) {
            const std::optional<double> metres = ParseLengthM(typed);
            if (!metres)
              return "\"" + typed +
                     "\" is no length; write metres, like 0.05, or the unit, like 5cm (m, cm, mm, in, ft).";
            typed = fmt::format("{}", *metres);
            return std::string();
          },
          "metres, or with a unit (5cm)", "length"};
}

void AddGsdOptions(CLI::App& command, std::optional<double>& gsd_m, bool& any_gsd) {
  command
      .add_option(
          "--gsd", gsd_m,
          "Ground size of a map pixel, in metres (0.05) or with its unit (5cm). Default: that of the photos")
      ->transform(Length());
  command.add_flag("--any-gsd", any_gsd,
                   "A --gsd of more than 20 times what a pixel of the photos shows is meant");
}

void RefuseNoNumbers(CLI::App& app) {
  const auto check = [](const std::string& text) {
    double number = 0.0;
    const bool is_none = CLI::detail::lexical_cast(text, number) && std::isnan(number);
    return is_none ? "\"" + text + "\" is no number" : std::string();
  };
  for (CLI::Option* option : app.get_options()) {
    if (option->get_type_name().starts_with("FLOAT")) option->check(check);
  }
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    RefuseNoNumbers(*command);
}

}  // namespace skyquilt::server
