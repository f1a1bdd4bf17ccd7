#include "server/watch/watch_process.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <system_error>

#include "server/routing/request_log.h"
#include "server/sandbox/spawn_process.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kFirstRestartPause{1'000}, kLongestRestartPause{60'000};
constexpr std::chrono::seconds kLivedWell{60};  // one that lived so long is started again at once

bool IsWithin(const fs::path& path, const fs::path& folder) {
  const fs::path below = path.lexically_relative(folder);
  return !below.empty() && *below.begin() != "..";
}

// As it is on the disk, where it is there; it may come later.
fs::path TruePath(const fs::path& path) {
  std::error_code unknown;
  const fs::path found = fs::weakly_canonical(path, unknown);
  return unknown ? fs::absolute(path).lexically_normal() : found;
}

}  // namespace

Result<void> CheckWatched(const WatchedFolders& watched, const fs::path& data_dir, bool requires_token) {
  const auto refuse = [](const std::string& why) { return Error{ErrorCode::kInvalidArgument, why}; };
  if (!watched.folders.empty() && requires_token && watched.token_file.empty())
    return refuse(
        "--watch: this server asks for a token. Make one with \"skyquilt token add watch --scope upload\", put "
        "it into a file, and name that with --watch-token-file.");
  const fs::path data = TruePath(data_dir);
  for (const std::string& folder : watched.folders) {
    const fs::path path = TruePath(folder);
    if (IsWithin(data, path) || IsWithin(path, data))
      return refuse("--watch " + folder +
                    ": the data folder lies in it, or it in the data folder. Watch another folder.");
  }
  return {};
}

std::vector<std::string> WatchWords(const WatchedFolders& watched, const fs::path& data_dir,
                                    const std::string& url) {
  if (watched.folders.empty()) return {};
  std::vector<std::string> words = {"watch"};
  words.insert(words.end(), watched.folders.begin(), watched.folders.end());
  const fs::path ledger = fs::absolute(data_dir) / "watch" / "sent.jsonl";
  words.insert(words.end(), {"--server", url, "--ledger", ledger.string()});
  if (!watched.token_file.empty()) words.insert(words.end(), {"--token-file", watched.token_file});
  return words;
}

WatchProcess::~WatchProcess() { Stop(std::chrono::milliseconds(0)); }

void WatchProcess::StartMissing() {
  if (words_.empty() || pid_ != 0 || Clock::now() < not_before_) return;
  started_ = Clock::now();
  // What it says belongs into the log.
  const Result<pid_t> started = SpawnSelf(words_, Secrets::kWithheld, STDERR_FILENO);
  if (started) {
    pid_ = *started;
    return;
  }
  LogFailure("-", "watch", "could not be started: " + started.error().detail);
  not_before_ = Clock::now() + kFirstRestartPause;
}

void WatchProcess::Reap() {
  int status = 0;
  if (pid_ == 0 || waitpid(pid_, &status, WNOHANG) != pid_) return;
  pid_ = 0;
  pause_ = Clock::now() - started_ > kLivedWell
               ? kFirstRestartPause
               : std::clamp(2 * pause_, kFirstRestartPause, kLongestRestartPause);
  not_before_ = Clock::now() + pause_;
  LogFailure("-", "watch",
             fmt::format("the process that watches folders ended {}; it is started again in {} s",
                         HowItEnded(status), pause_.count() / 1000));
}

void WatchProcess::Stop(std::chrono::milliseconds grace) {
  if (pid_ == 0) return;
  kill(pid_, SIGTERM);
  WaitOrKill(pid_, grace);
  pid_ = 0;
}

}  // namespace skyquilt::server
