#include "server/manual/completions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>
#include <vector>

#include "core/base/text/xml_text.h"

namespace skyquilt::server {
namespace {

std::vector<std::string> NamesOfAll(const std::vector<DescribedOption>& options) {
  std::vector<std::string> names;
  for (const DescribedOption& option : options)
    names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

std::string BashCase(const std::vector<std::string>& patterns, const std::string& action) {
  std::vector<std::string> quoted;
  for (const std::string& pattern : patterns) quoted.push_back("'" + pattern + "'");
  return fmt::format("    {}) {} ;;\n", fmt::join(quoted, " | "), action);
}

// What comes after an option that takes a value, one line for each such option of a command.
std::string CasesOfValues(const DescribedCommand& command) {
  std::string cases;
  for (const DescribedOption& option : command.options) {
    if (option.value.empty()) continue;
    std::vector<std::string> patterns;
    for (const std::string& name : option.names) patterns.push_back(command.Words() + ":" + name);
    if (!option.words.empty()) {
      cases += BashCase(patterns, fmt::format("_skyquilt_words '{}'; return", fmt::join(option.words, " ")));
    } else {
      cases += BashCase(patterns, option.MayNameFile() ? "_skyquilt_files; return" : "return");
    }
  }
  for (const DescribedCommand& below : command.commands) cases += CasesOfValues(below);
  return cases;
}

std::string CasesOfCommands(const DescribedCommand& command) {
  std::vector<std::string> words = NamesOfAll(command.options);
  for (const DescribedCommand& below : command.commands) words.push_back(below.path.back());
  for (const DescribedOption& argument : command.arguments)
    words.insert(words.end(), argument.words.begin(), argument.words.end());
  std::string cases = BashCase({command.Words()}, fmt::format("words='{}'", fmt::join(words, " ")));
  for (const DescribedCommand& below : command.commands) cases += CasesOfCommands(below);
  return cases;
}

}  // namespace

std::string BashCompletion(const DescribedCommand& program) {
  std::vector<std::string> with_commands;
  std::vector<std::string> without_files;
  const auto sort_out = [&](const auto& self, const DescribedCommand& command) -> void {
    bool takes_files = false;
    for (const DescribedOption& argument : command.arguments) takes_files |= argument.MayNameFile();
    if (!takes_files) without_files.push_back(command.Words());
    for (const DescribedCommand& below : command.commands) {
      if (!below.commands.empty()) with_commands.push_back(below.Words());
      self(self, below);
    }
  };
  sort_out(sort_out, program);
  std::string script =
      "# bash completion for skyquilt; made by \"skyquilt completion bash\".\n"
      "_skyquilt_words() { mapfile -t COMPREPLY < <(compgen -W \"$1\" -- \"$current\"); }\n"
      "_skyquilt_files() { COMPREPLY=(); compopt -o default 2>/dev/null || true; }\n"
      "_skyquilt() {\n"
      "  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command=skyquilt words=\n"
      "  COMPREPLY=()\n"
      "  # bash takes --option=value for three words.\n"
      "  if [[ $current == '=' ]]; then\n"
      "    current=\n"
      "  elif [[ $before == '=' ]] && ((COMP_CWORD >= 2)); then\n"
      "    before=${COMP_WORDS[COMP_CWORD - 2]}\n"
      "  fi\n"
      "  if ((COMP_CWORD >= 2)); then command+=\" ${COMP_WORDS[1]}\"; fi\n"
      "  case $command in\n";
  script += BashCase(with_commands, "if ((COMP_CWORD >= 3)); then command+=\" ${COMP_WORDS[2]}\"; fi");
  script += "  esac\n  case $command:$before in\n" + CasesOfValues(program);
  script += "  esac\n  case $command in\n" + CasesOfCommands(program);
  script +=
      "    *) _skyquilt_files; return ;;\n"
      "  esac\n"
      "  case $command in\n";
  script += BashCase(without_files, "_skyquilt_words \"$words\"; return");
  script +=
      "  esac\n"
      "  if [[ $current == -* ]]; then _skyquilt_words \"$words\"; else _skyquilt_files; fi\n"
      "}\n"
      "complete -F _skyquilt skyquilt\n";
  return script;
}

namespace {

std::string QuotedForFish(std::string_view text) {
  return "'" + Escaped(text, {{'\'', "\\'"}, {'\\', "\\\\"}, {'\n', " "}}) + "'";
}

std::string PathOf(const DescribedCommand& command) {
  return fmt::format("{}", fmt::join(command.path, " "));
}

std::string FishOption(const std::string& at, const DescribedOption& option) {
  std::string line = fmt::format("complete -c skyquilt -n {}", at);
  for (const std::string& name : option.names)
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  if (!option.words.empty()) {
    line += fmt::format(" -x -a '{}'", fmt::join(option.words, " "));
  } else if (!option.value.empty()) {
    line += option.MayNameFile() ? " -r -F" : " -x";
  }
  return line + " -d " + QuotedForFish(option.about) + "\n";
}

std::string FishCommand(const DescribedCommand& command) {
  const std::string at = QuotedForFish("__skyquilt_at " + PathOf(command));
  std::string lines;
  bool takes_files = false;
  for (const DescribedOption& argument : command.arguments) {
    takes_files |= argument.MayNameFile();
    if (argument.words.empty()) continue;
    lines += fmt::format("complete -c skyquilt -n {} -a '{}' -d {}\n", at, fmt::join(argument.words, " "),
                         QuotedForFish(argument.about));
  }
  if (!takes_files) lines = fmt::format("complete -c skyquilt -n {} -f\n", at) + lines;
  for (const DescribedCommand& below : command.commands)
    lines += fmt::format("complete -c skyquilt -n {} -a {} -d {}\n", at, below.path.back(),
                         QuotedForFish(below.about));
  for (const DescribedOption& option : command.options) lines += FishOption(at, option);
  for (const DescribedCommand& below : command.commands) lines += FishCommand(below);
  return lines;
}

}  // namespace

std::string FishCompletion(const DescribedCommand& program) {
  std::vector<std::string> with_commands;
  for (const DescribedCommand& command : program.commands)
    if (!command.commands.empty()) with_commands.push_back(command.path.back());
  return fmt::format(
             "# fish completion for skyquilt; made by \"skyquilt completion fish\".\n"
             "# Whether the words before the cursor are those of this command.\n"
             "function __skyquilt_at\n"
             "    set -l words (commandline -opc)\n"
             "    set -l command $words[2]\n"
             "    if contains -- \"$command\" {}\n"
             "        set command $command $words[3]\n"
             "    end\n"
             "    test \"$command\" = \"$argv\"\n"
             "end\n",
             fmt::join(with_commands, " ")) +
         FishCommand(program);
}

namespace {

// Between single quotes, inside a specification of _arguments or _describe.
std::string TextForZsh(std::string_view text) {
  return Escaped(text, {{'\'', "'\\''"}, {'[', "("}, {']', ")"}, {':', "\\:"}, {'\\', "\\\\"}, {'\n', " "}});
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
