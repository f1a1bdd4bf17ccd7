// WatchProcess: the process of a server that makes flights of the folders it watches: "skyquilt watch" of
// this binary, a client of this server like any other. Started again where it ended, the later the oftener it
// does so; ended with the server. Used by the main thread only: the kernel ends it when the thread that
// started it ends. WatchWords: what it is started with.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::server {

struct WatchedFolders {
  std::vector<std::string> folders;
  std::string token_file;  // empty: this server asks for no token
};

// Errors: kInvalidArgument (a folder holds the data folder or lies in it; a token is asked for and none was
// given).
Result<void> CheckWatched(const WatchedFolders& watched, const std::filesystem::path& data_dir,
                          bool requires_token);

// `url`: of this server, as this machine reaches it. What was sent is remembered in the data folder.
std::vector<std::string> WatchWords(const WatchedFolders& watched, const std::filesystem::path& data_dir,
                                    const std::string& url);

class WatchProcess {
 public:
  // `words`: empty where nothing is watched.
  explicit WatchProcess(std::vector<std::string> words) : words_(std::move(words)) {}
  ~WatchProcess();
  WatchProcess(const WatchProcess&) = delete;
  WatchProcess& operator=(const WatchProcess&) = delete;

  // Starts it where it should run and does not. Called at the start, and now and then.
  void StartMissing();
  // Collects it where it ended. Called on SIGCHLD.
  void Reap();
  // SIGTERM, on which it ends at once: what it sent lies here, the rest it sends at the next start.
  void Stop(std::chrono::milliseconds grace);

 private:
  using Clock = std::chrono::steady_clock;
  const std::vector<std::string> words_;
  pid_t pid_ = 0;  // 0: it does not run
  Clock::time_point started_, not_before_;
  std::chrono::milliseconds pause_{0};
};

}  // namespace skyquilt::server
