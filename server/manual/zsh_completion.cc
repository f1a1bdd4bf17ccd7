#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>
#include <vector>

#include "server/manual/completions.h"

namespace skyquilt::server {
namespace {

// Between single quotes, inside a specification of _arguments or _describe.
std::string TextForZsh(std::string_view text) {
  std::string escaped;
  for (const char letter : text) {
    if (letter == '\'') {
      escaped += "'\\''";
    } else if (letter == '[') {
      escaped += '(';
    } else if (letter == ']') {
      escaped += ')';
    } else if (letter == ':' || letter == '\\') {
      escaped += std::string("\\") + letter;
    } else {
      escaped += letter == '\n' ? ' ' : letter;
    }
  }
  return escaped;
}

std::string FunctionOf(const DescribedCommand& command) {
  return fmt::format("_skyquilt{}{}", command.path.empty() ? "" : "_", fmt::join(command.path, "_"));
}

std::string ActionOf(const DescribedOption& option) {
  if (!option.words.empty()) return fmt::format("({})", fmt::join(option.words, " "));
  return option.MayNameFile() ? "_files" : " ";
}

std::string ZshOption(const DescribedOption& option) {
  std::string lines;
  const std::string others = option.takes_several || option.names.size() < 2
                                 ? ""
                                 : fmt::format("({})", fmt::join(option.names, " "));
  for (const std::string& name : option.names) {
    lines += fmt::format(
        " \\\n    '{}{}{}{}[{}]{}'", option.takes_several ? "*" : "", others, name,
        option.value.empty()     ? ""
        : name.starts_with("--") ? "="
                                 : "+",
        TextForZsh(option.about),
        option.value.empty() ? "" : fmt::format(":{}:{}", TextForZsh(option.value), ActionOf(option)));
  }
  return lines;
}

std::string ZshCommand(const DescribedCommand& command) {
  std::string text = fmt::format("{}() {{\n", FunctionOf(command));
  if (!command.commands.empty()) text += "  local curcontext=$curcontext state line\n  typeset -A opt_args\n";
  text += command.commands.empty() ? "  _arguments -s" : "  _arguments -C";
  for (const DescribedOption& option : command.options) text += ZshOption(option);
  for (std::size_t i = 0; i < command.arguments.size(); ++i) {
    const DescribedOption& argument = command.arguments[i];
    text += fmt::format(" \\\n    '{}:{}:{}'",
                        argument.takes_several ? std::string("*")
                                               : fmt::format("{}{}", i + 1, argument.is_required ? "" : ":"),
                        TextForZsh(argument.names.front()), ActionOf(argument));
  }
  if (command.commands.empty()) return text + "\n}\n";
  text +=
      " \\\n    '1:command:->command' '*::rest:->rest'\n  case $state in\n    command)\n      local -a commands=(";
  for (const DescribedCommand& below : command.commands)
    text += fmt::format("\n        '{}:{}'", below.path.back(), TextForZsh(below.about));
  text += ")\n      _describe -t commands command commands\n      ;;\n    rest)\n      case $words[1] in\n";
  for (const DescribedCommand& below : command.commands)
    text += fmt::format("        {}) {} ;;\n", below.path.back(), FunctionOf(below));
  text += "      esac\n      ;;\n  esac\n}\n";
  for (const DescribedCommand& below : command.commands) text += ZshCommand(below);
  return text;
}

}  // namespace

std::string ZshCompletion(const DescribedCommand& program) {
  return "#compdef skyquilt\n# zsh completion for skyquilt; made by \"skyquilt completion zsh\".\n" +
         ZshCommand(program) +
         "if [ \"$funcstack[1]\" = _skyquilt ]; then _skyquilt \"$@\"; else compdef _skyquilt skyquilt; fi\n";
}

}  // namespace skyquilt::server
