#include "server/manual/manual_command.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>
#include <system_error>
#include <vector>

#include "server/manual/completions.h"
#include "server/manual/described_command.h"
#include "server/manual/manual_page.h"
#include "server/terminal/fail.h"
#include "server/usage/explain_usage.h"
#include "server/usage/option_values.h"

namespace skyquilt::server {
namespace {

struct ManualOptions {
  std::string command;  // empty: the page of the program
  std::string out_dir;
  std::string shell;
};

// Today, or the day that a reproducible build asks for.
std::string DayOfPages() {
  std::time_t seconds = std::time(nullptr);
  if (const char* epoch = std::getenv("SOURCE_DATE_EPOCH")) {
    const std::string_view text = epoch;
    std::from_chars(text.data(), text.data() + text.size(), seconds);
  }
  std::tm day{};
  gmtime_r(&seconds, &day);
  return fmt::format("{:%Y-%m-%d}", day);
}

void WritePage(const std::filesystem::path& folder, const std::string& name, const std::string& text) {
  const std::filesystem::path path = folder / (name + ".1");
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) {
    Fail("skyquilt man",
         {ErrorCode::kIo,
          fmt::format("{} cannot be written. Give --out a folder that you may write to.", path.string())});
  }
}

const DescribedCommand& CommandToShow(const DescribedCommand& program, const std::string& name) {
  if (name.empty()) return program;
  std::vector<std::string> names;
  for (const DescribedCommand& command : program.commands) {
    if (command.path.back() == name) return command;
    names.push_back(command.path.back());
  }
  const std::optional<std::string> near = NearWord(name, names);
  Fail("skyquilt man", {ErrorCode::kNotFound, fmt::format("There is no command \"{}\".{}", name,
                                                          near ? " Did you mean " + *near + "?" : "")});
}

void Man(CLI::App& app, const std::string& version, const ManualOptions& options) {
  const DescribedCommand program = Describe(app);
  const std::string day = DayOfPages();
  if (options.out_dir.empty()) {
    fmt::print("{}", ManualPage(CommandToShow(program, options.command), program, version, day));
    return;
  }
  std::error_code failed;  // said by what cannot be written then
  std::filesystem::create_directories(options.out_dir, failed);
  WritePage(options.out_dir, NameOfManualPage(program), ManualPage(program, program, version, day));
  for (const DescribedCommand& command : program.commands)
    WritePage(options.out_dir, NameOfManualPage(command), ManualPage(command, program, version, day));
}

void Completion(CLI::App& app, const ManualOptions& options) {
  const DescribedCommand program = Describe(app);
  fmt::print("{}", options.shell == "bash"   ? BashCompletion(program)
                   : options.shell == "fish" ? FishCompletion(program)
                                             : ZshCompletion(program));
}

}  // namespace

void AddManualCommands(CLI::App& app, const std::string& version) {
  const auto options = std::make_shared<ManualOptions>();
  CLI::App* man = app.add_subcommand("man", "Print a manual page of the program or of one of its commands");
  man->add_option("command", options->command, "The command whose page it is (default: the program)");
  man->add_option("--out", options->out_dir, "Write the pages of all commands into this folder")
      ->excludes("command");
  man->callback([&app, version, options] { Man(app, version, *options); });
  CLI::App* completion =
      app.add_subcommand("completion", "Print what a shell loads to complete commands and options by Tab");
  completion->add_option("shell", options->shell, "The shell that it is for")
      ->check(OneOf(std::vector<std::string>{"bash", "zsh", "fish"}))
      ->required();
  completion->callback([&app, options] { Completion(app, *options); });
}

}  // namespace skyquilt::server
