// DescribedCommand: what the program's commands and options are called and say of themselves, taken from
// their declarations, so that manual pages and completions cannot differ from what the program takes. Values;
// any thread. Commands and options that help does not list are left out.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace skyquilt::server {

struct DescribedOption {
  std::vector<std::string> names;  // "-o", "--out"; one name without dashes for an argument
  std::string value;               // kind of value: "TEXT", "INT"; empty: a flag
  std::vector<std::string> words;  // the values, where it takes one of several words
  std::string bounds;              // of other values, as help says them; may be empty
  std::string about;
  std::string default_value;  // empty: none that help shows
  std::string variable;       // of the environment; may be empty
  bool is_required = false;
  bool takes_several = false;

  // Text that is none of several words may name a file.
  bool MayNameFile() const;
};

struct DescribedCommand {
  std::vector<std::string> path;  // {"token", "add"}; empty: the program
  std::string about;
  std::string footer;  // what help says below the options: sentences, then examples, which are indented
  std::vector<DescribedOption> options;
  std::vector<DescribedOption> arguments;
  std::vector<DescribedCommand> commands;

  std::string Words() const;  // "skyquilt token add"
};

DescribedCommand Describe(CLI::App& app);

}  // namespace skyquilt::server
