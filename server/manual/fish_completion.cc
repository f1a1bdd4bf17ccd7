#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>
#include <vector>

#include "server/manual/completions.h"

namespace skyquilt::server {
namespace {

std::string QuotedForFish(std::string_view text) {
  std::string quoted = "'";
  for (const char letter : text) {
    if (letter == '\'' || letter == '\\') quoted += '\\';
    quoted += letter == '\n' ? ' ' : letter;
  }
  return quoted + "'";
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

}  // namespace skyquilt::server
