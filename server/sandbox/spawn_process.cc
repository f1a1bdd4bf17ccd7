#include "server/sandbox/spawn_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <thread>

#include "core/base/process/file_descriptor.h"
#include "core/base/try.h"
#include "storage/files/publish_file.h"

extern char** environ;

namespace skyquilt::server {
namespace {

constexpr std::chrono::milliseconds kProgramPollInterval{100};
constexpr std::chrono::milliseconds kUntilGone{2};  // between two checks whether a process has ended
constexpr int kBehindOthers = 10;                   // nice

class SpawnSettings {
 public:
  SpawnSettings() {
    posix_spawnattr_init(&attributes_);
    posix_spawn_file_actions_init(&actions_);
    sigset_t none;
    sigset_t all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  void Take(std::optional<int> fd, int as) {
    if (fd) posix_spawn_file_actions_adddup2(&actions_, *fd, as);
  }
  void TakeNothing(int as, int flags) {
    posix_spawn_file_actions_addopen(&actions_, as, "/dev/null", flags, 0);
  }
  void OfAGroupOfItsOwn() {
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(&attributes_,
                             POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  }
  // After what is taken.
  void TakeNoOther() {
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

std::vector<char*> ListOf(std::vector<std::string>& texts) {
  std::vector<char*> list;
  for (std::string& text : texts) list.push_back(text.data());
  list.push_back(nullptr);
  return list;
}

Result<pid_t> Spawn(const char* program, const SpawnSettings& settings, std::vector<char*> argv,
                    std::vector<char*> variables) {
  pid_t pid = 0;
  const int failed =
      posix_spawn(&pid, program, settings.actions(), settings.attributes(), argv.data(), variables.data());
  if (failed == 0) return pid;
  return Error{ErrorCode::kUnavailable, "The server could not start a process. Try again later.",
               std::strerror(failed)};
}

// What libraries and sanitizers read, and programs that are found. Any other variable may hold a key: that of
// a proxy its password.
bool IsWithoutSecret(std::string_view name) {
  constexpr std::array<std::string_view, 11> kNames{
      "PATH",     "HOME",      "TMPDIR",          "LANG", "TZ", "LD_LIBRARY_PATH", "LD_PRELOAD", "PROJ_DATA",
      "PROJ_LIB", "GDAL_DATA", "GDAL_DRIVER_PATH"};
  return std::find(kNames.begin(), kNames.end(), name) != kNames.end() || name.starts_with("LC_") ||
         name.starts_with("OPENBLAS_") || name.starts_with("MALLOC_") || name.ends_with("SAN_OPTIONS");
}

std::vector<char*> EnvironmentFor(Secrets secrets) {
  std::vector<char*> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text(*variable);
    if (secrets == Secrets::kKept || IsWithoutSecret(text.substr(0, text.find('='))))
      variables.push_back(*variable);
  }
  variables.push_back(nullptr);
  return variables;
}

Result<pid_t> SpawnOther(const ProgramToRun& program, int log_fd) {
  std::vector<std::string> words = program.words;
  std::vector<std::string> environment = program.environment;
  words.insert(words.begin(), program.path);
  SpawnSettings settings;
  settings.OfAGroupOfItsOwn();
  settings.Take(log_fd, STDERR_FILENO);
  settings.TakeNothing(STDIN_FILENO, O_RDONLY);
  settings.TakeNothing(STDOUT_FILENO, O_WRONLY);
  settings.TakeNoOther();
  return Spawn(program.path.c_str(), settings, ListOf(words), ListOf(environment));
}

void Limit(pid_t pid, const ProgramToRun& program) {
  const auto set = [&](auto what, std::int64_t most) {
    const rlimit limit{static_cast<rlim_t>(most), static_cast<rlim_t>(most)};
    prlimit(pid, what, &limit, nullptr);
  };
  set(RLIMIT_CPU, program.cpu_s);
  set(RLIMIT_FSIZE, program.file_bytes);
  set(RLIMIT_CORE, 0);
  setpriority(PRIO_PGRP, static_cast<id_t>(pid), kBehindOthers);
}

}  // namespace

Result<pid_t> SpawnSelf(std::vector<std::string> words, Secrets secrets, std::optional<int> stdout_fd,
                        std::optional<int> stdin_fd) {
  words.insert(words.begin(), "skyquilt");
  words.insert(words.end(), {"--parent", std::to_string(getpid())});
  SpawnSettings settings;
  settings.Take(stdin_fd, STDIN_FILENO);
  settings.Take(stdout_fd, STDOUT_FILENO);
  settings.TakeNoOther();
  return Spawn("/proc/self/exe", settings, ListOf(words), EnvironmentFor(secrets));
}

ProcessEnd WaitOrKill(pid_t pid, std::chrono::milliseconds patience, const std::function<bool()>& go_on) {
  const auto last = std::chrono::steady_clock::now() + patience;
  ProcessEnd end;
  while (true) {
    const pid_t ended = wait4(pid, &end.wait_status, WNOHANG, &end.used);
    if (ended == pid) return end;
    if (ended < 0 && errno != EINTR) return end;  // somebody else collected it: it is gone all the same
    if (std::chrono::steady_clock::now() >= last || (go_on && !go_on())) break;
    std::this_thread::sleep_for(kUntilGone);
  }
  kill(pid, SIGKILL);
  while (wait4(pid, &end.wait_status, 0, &end.used) < 0 && errno == EINTR) {
  }
  return end;
}

std::string HowItEnded(int wait_status) {
  if (!WIFSIGNALED(wait_status)) return fmt::format("with code {}", WEXITSTATUS(wait_status));
  const int number = WTERMSIG(wait_status);
  return fmt::format("by signal {} ({})", number, strsignal(number));
}

Result<int> RunProgram(const ProgramToRun& program, const std::function<bool()>& go_on) {
  const FileDescriptor log(open(program.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  if (!log.is_open()) return storage::FileError("cannot write", program.log, errno);
  SKYQUILT_TRY_ASSIGN(const pid_t pid, SpawnOther(program, log.get()));
  Limit(pid, program);
  const auto end = std::chrono::steady_clock::now() + program.wall;
  const auto stopped = [&](ErrorCode code, std::string message) {
    kill(-pid, SIGKILL);
    WaitOrKill(pid, std::chrono::milliseconds(0));
    return Error{code, std::move(message), program.path};
  };
  while (true) {
    int status = 0;
    const pid_t ended = waitpid(pid, &status, WNOHANG);
    if (ended == pid) {
      kill(-pid, SIGKILL);  // what it left behind
      return status;
    }
    if (ended < 0 && errno != EINTR)
      return stopped(ErrorCode::kUnavailable, "A program was lost. Try again.");
    if (go_on && !go_on()) return stopped(ErrorCode::kCancelled, "This was cancelled.");
    if (std::chrono::steady_clock::now() >= end)
      return stopped(ErrorCode::kTimeout,
                     fmt::format("{} took more than {} minutes.", program.path, program.wall.count() / 60));
    std::this_thread::sleep_for(kProgramPollInterval);
  }
}

}  // namespace skyquilt::server
