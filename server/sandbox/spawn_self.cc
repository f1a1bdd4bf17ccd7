#include "server/sandbox/spawn_self.h"

#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <string_view>

extern char** environ;

namespace skyquilt::server {
namespace {

class SpawnSettings {
 public:
  SpawnSettings(std::optional<int> stdout_fd, std::optional<int> stdin_fd) {
    posix_spawnattr_init(&attributes_);
    posix_spawn_file_actions_init(&actions_);
    sigset_t none;
    sigset_t all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    if (stdin_fd) posix_spawn_file_actions_adddup2(&actions_, *stdin_fd, STDIN_FILENO);
    if (stdout_fd) posix_spawn_file_actions_adddup2(&actions_, *stdout_fd, STDOUT_FILENO);
    // Asio's sockets would go along: a child that outlives a killed server kept its port from the next one.
    posix_spawn_file_actions_addclosefrom_np(&actions_, STDERR_FILENO + 1);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  const posix_spawnattr_t* attributes() const { return &attributes_; }
  const posix_spawn_file_actions_t* actions() const { return &actions_; }

 private:
  posix_spawnattr_t attributes_{};
  posix_spawn_file_actions_t actions_{};
};

std::vector<char*> EnvironmentFor(Secrets secrets) {
  std::vector<char*> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text(*variable);
    const bool is_secret = text.starts_with("AWS_") || text.starts_with("PG");
    if (secrets == Secrets::kKept || !is_secret) variables.push_back(*variable);
  }
  variables.push_back(nullptr);
  return variables;
}

}  // namespace

Result<pid_t> SpawnSelf(std::vector<std::string> words, Secrets secrets, std::optional<int> stdout_fd,
                        std::optional<int> stdin_fd) {
  words.insert(words.begin(), "skyquilt");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const SpawnSettings settings(stdout_fd, stdin_fd);
  std::vector<char*> variables = EnvironmentFor(secrets);
  pid_t pid = 0;
  const int failed = posix_spawn(&pid, "/proc/self/exe", settings.actions(), settings.attributes(),
                                 argv.data(), variables.data());
  if (failed == 0) return pid;
  return Error{ErrorCode::kUnavailable, "The server could not start a process. Try again later.",
               std::strerror(failed)};
}

std::string HowItEnded(int wait_status) {
  if (!WIFSIGNALED(wait_status)) return fmt::format("with code {}", WEXITSTATUS(wait_status));
  const int number = WTERMSIG(wait_status);
  return fmt::format("by signal {} ({})", number, strsignal(number));
}

}  // namespace skyquilt::server
