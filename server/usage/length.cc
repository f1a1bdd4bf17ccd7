#include "server/usage/length.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <string>
#include <utility>

namespace skyquilt::server {
namespace {

constexpr std::pair<std::string_view, double> kUnits[] = {{"", 1.0},     {"m", 1.0},     {"cm", 0.01},
                                                          {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};

}  // namespace

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

}  // namespace skyquilt::server
