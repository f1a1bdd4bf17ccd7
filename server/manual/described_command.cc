#include "server/manual/described_command.h"

#include <CLI/CLI.hpp>
#include <utility>

#include "server/usage/option_values.h"

namespace skyquilt::server {
namespace {

DescribedOption DescribeOption(CLI::Option& option) {
  DescribedOption described;
  const bool is_argument = option.get_snames().empty() && option.get_lnames().empty();
  if (is_argument) {
    described.names.push_back(option.get_name(true));
  } else {
    for (const std::string& name : option.get_snames()) described.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) described.names.push_back("--" + name);
  }
  if (option.get_items_expected_max() > 0) {
    const std::string kind = option.get_type_name();
    const std::size_t colon = kind.find(':');
    described.value = kind.substr(0, colon);
    if (described.value.empty()) described.value = "VALUE";
    described.words = WordsOf(option);
    if (described.words.empty() && colon != std::string::npos) described.bounds = kind.substr(colon + 1);
    described.takes_several = option.get_items_expected_max() > 1;
  }
  described.about = option.get_description();
  described.default_value = option.get_default_str();
  described.variable = option.get_envname();
  described.is_required = option.get_required();
  return described;
}

DescribedCommand DescribeCommand(CLI::App& app, std::vector<std::string> path) {
  DescribedCommand described{std::move(path), app.get_description(), app.get_footer(), {}, {}, {}};
  for (CLI::Option* option : app.get_options([](const CLI::Option*) { return true; })) {
    if (option->get_group().empty()) continue;
    DescribedOption one = DescribeOption(*option);
    (one.names.front().starts_with('-') ? described.options : described.arguments).push_back(std::move(one));
  }
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
    if (command->get_group().empty()) continue;
    std::vector<std::string> words = described.path;
    words.push_back(command->get_name());
    described.commands.push_back(DescribeCommand(*command, std::move(words)));
  }
  return described;
}

}  // namespace

bool DescribedOption::MayNameFile() const { return words.empty() && (value == "TEXT" || value == "VALUE"); }

std::string DescribedCommand::Words() const {
  std::string words = "skyquilt";
  for (const std::string& word : path) words += " " + word;
  return words;
}

DescribedCommand Describe(CLI::App& app) { return DescribeCommand(app, {}); }

}  // namespace skyquilt::server
