#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "server/manual/completions.h"

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
  std::string others;
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

}  // namespace skyquilt::server
