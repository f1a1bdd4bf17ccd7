#include <fmt/format.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <system_error>

#include "core/base/digest.h"
#include "core/base/text/printable.h"
#include "server/commands/arguments.h"
#include "server/commands/commands.h"
#include "server/jobs/out_folder.h"
#include "server/sandbox/sandbox.h"
#include "server/terminal/fail.h"
#include "server/watch/watch_folders.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWatchCommand = "skyquilt watch";

struct WatchArguments {
  WatchOptions options;
  std::string state_dir, ledger, token_file;
  int parent = 0;
  double settle_s = 20.0, gap_min = 30.0;
  int patience_s = 600;
  bool no_map = false;
};

// Where programs keep what is neither configuration nor cache (XDG Base Directory Specification 0.8).
fs::path StateFolder() {
  const char* state = std::getenv("XDG_STATE_HOME");
  if (state != nullptr && fs::path(state).is_absolute()) return fs::path(state) / "skyquilt";
  const char* home = std::getenv("HOME");
  if (home != nullptr && *home != '\0') return fs::path(home) / ".local" / "state" / "skyquilt";
  Refuse(kWatchCommand, "Nothing says where to remember what was sent: set HOME, or give --state.");
}

fs::path LedgerOf(const WatchArguments& arguments) {
  if (!arguments.ledger.empty()) return arguments.ledger;
  Hasher hasher;
  const Digest server = hasher.Add(std::string_view(arguments.options.send.server.url)).Finish();
  return (arguments.state_dir.empty() ? StateFolder() : fs::path(arguments.state_dir)) /
         ("sent-" + HexOf(server).substr(0, 16) + ".jsonl");
}

// The first line of the file.
std::string TokenIn(const std::string& path) {
  std::string token;
  if (std::ifstream file(path); !std::getline(file, token))
    Fail(kWatchCommand, {ErrorCode::kIo, "--token-file " + path + ": no token can be read from it."});
  while (!token.empty() && (token.back() == '\r' || token.back() == ' ')) token.pop_back();
  return token;
}

void Run(WatchArguments& arguments) {
  if (arguments.parent != 0 && !FollowParent(arguments.parent, SIGTERM)) return;
  WatchOptions& options = arguments.options;
  if (!arguments.token_file.empty()) options.send.server.token = TokenIn(arguments.token_file);
  ClientSettings& server = options.send.server;
  CheckServerAddress(kWatchCommand, server.url);
  // A break of this length within one file is waited out there; a longer one by the watch itself.
  server.patience = std::chrono::seconds(std::min(30, arguments.patience_s));
  options.patience = std::chrono::seconds(arguments.patience_s);
  options.rules.settle = std::chrono::milliseconds(std::lround(1000.0 * arguments.settle_s));
  options.rules.gap = std::chrono::seconds(std::lround(60.0 * arguments.gap_min));
  options.send.makes_map = !arguments.no_map;
  options.passes_over = IsOfMap;
  for (fs::path& folder : options.folders) {
    folder = fs::absolute(folder).lexically_normal();
    if (!folder.has_filename()) folder = folder.parent_path();
    std::error_code gone;
    if (fs::is_regular_file(folder, gone))
      Refuse(kWatchCommand, folder.string() + " is a file. Name a folder; \"skyquilt upload\" sends files.");
  }
  options.ledger = LedgerOf(arguments);
  const WatchEnd ended = OrFail(kWatchCommand, [&] {
    WatchTalk talk;
    return WatchFolders(options, talk);
  }());
  fmt::print("{}, {} sent\n", Counted(ended.flights, "new flight"), Counted(ended.files, "file"));
  if (options.once && ended.refused > 0) throw CLI::RuntimeError(1);
}

}  // namespace

void AddWatchCommand(CLI::App& app) {
  const auto arguments = std::make_shared<WatchArguments>();
  WatchOptions& options = arguments->options;
  CLI::App* command =
      app.add_subcommand("watch", "Send cards and folders to a server as they fill, flight by flight");
  command->add_option("DIR", options.folders, "Folders or mount points; what is not there yet is waited for")
      ->required();
  options.send.server.url = "http://127.0.0.1:8080";
  command->add_option("--server", options.send.server.url, "Address of the server")->capture_default_str();
  command->add_option("--token", options.send.server.token, "Token, where the server asks for one")
      ->envname("SKYQUILT_TOKEN");
  command->add_option("--token-file", arguments->token_file, "File with the token, instead of --token");
  command->add_flag("--once", options.once, "Send what is there and end, for cron or udev");
  command
      ->add_option("--settle", arguments->settle_s,
                   "Seconds in which nothing of a flight may have changed before it is sent")
      ->check(CLI::Range(0.1, 86'400.0))
      ->capture_default_str();
  command
      ->add_option("--gap", arguments->gap_min,
                   "Minutes between two photos beyond which they are two flights")
      ->check(CLI::Range(0.1, 100'000.0))
      ->capture_default_str();
  command
      ->add_option("--min-photos", options.rules.min_photos, "Leave flights of fewer photos where they are")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  command->add_option("--name", options.send.name_prefix, "Put before the names of flights");
  command->add_flag("--no-map", arguments->no_map, "Send the files and make no maps yet");
  command
      ->add_option("--patience", arguments->patience_s,
                   "With --once, seconds that a server which is away is asked again")
      ->check(CLI::Range(0, 86'400))
      ->capture_default_str();
  command->add_option("--state", arguments->state_dir,
                      "Folder that remembers what was sent (default: skyquilt in $XDG_STATE_HOME, or "
                      "in ~/.local/state)");
  // For the watch of a server, which starts it.
  command->add_option("--ledger", arguments->ledger)->group("");
  command->add_option("--parent", arguments->parent)->group("");
  command->footer(
      "\nA flight is what one camera took in one folder without a pause of --gap minutes; folders that a camera\n"
      "numbers as they fill (100MEDIA, 101MEDIA) count as one. Logs, lists and elevation models beside the photos\n"
      "go with them, films do not. Photos that come later join their flight, and its map is made again. What was\n"
      "sent is known by its content: a card put in twice makes nothing twice. Nothing on the card is changed. A\n"
      "server or a disk that is away is waited for. Ctrl-C or SIGTERM ends it; the next start goes on.\n"
      "Example:\n"
      "  skyquilt watch /media/sd --server http://maps.example:8080");
  command->callback([arguments] { Run(*arguments); });
}

}  // namespace skyquilt::server
