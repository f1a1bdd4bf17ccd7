#include "server/sandbox/sandbox.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>
#include <utility>

#include "core/base/process/file_descriptor.h"
#include "core/base/process/late_library.h"
#include "core/base/try.h"
#include "server/sandbox/system_calls.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

// At RLIMIT_CPU a signal comes, which a process can ignore; so much later it is killed.
constexpr rlim_t kCpuBeyondSignalS = 5;

// For good: the process may move its soft limit `beyond` that, and no further.
void Limit(int resource, rlim_t soft, rlim_t beyond = 0) {
  rlimit limit{};
  getrlimit(static_cast<__rlimit_resource>(resource), &limit);
  limit.rlim_cur = std::min(soft, limit.rlim_max);
  limit.rlim_max = std::min(soft + beyond, limit.rlim_max);
  setrlimit(static_cast<__rlimit_resource>(resource), &limit);
}

std::int64_t AddressSpaceBytes() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t pages = 0;
  statm >> pages;
  return pages * sysconf(_SC_PAGESIZE);
}

// As RLIMIT_DATA counts it.
std::int64_t DataBytes() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    std::int64_t kib = 0;
    if (word == "VmData:" && status >> kib) return kib << 10;
  }
  return 0;
}

// Debian 12's header ends at version 2; the numbers are the kernel's for good.
constexpr int kFirstUsableVersion = 2;
constexpr std::uint64_t kTruncate = std::uint64_t{1} << 14;     // from version 3 on
constexpr std::uint64_t kDeviceIoctl = std::uint64_t{1} << 15;  // from version 5 on
constexpr std::uint64_t kBindTcp = 1, kConnectTcp = 2;          // from version 4 on
constexpr std::uint64_t kAbstractSockets = 1, kSignals = 2;     // from version 6 on

struct RulesetAttributes {
  std::uint64_t files = 0;
  std::uint64_t net = 0;
  std::uint64_t scoped = 0;
};

constexpr std::uint64_t kReadFile = LANDLOCK_ACCESS_FS_READ_FILE;
constexpr std::uint64_t kRead = kReadFile | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t kWriteFile = LANDLOCK_ACCESS_FS_WRITE_FILE | kTruncate;
// No links, sockets, pipes or devices: whoever takes the folder over must not follow one.
constexpr std::uint64_t kWrite = kRead | kWriteFile | LANDLOCK_ACCESS_FS_REMOVE_DIR |
                                 LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_MAKE_DIR |
                                 LANDLOCK_ACCESS_FS_MAKE_REG | LANDLOCK_ACCESS_FS_REFER;
// What is meant for a folder and makes no sense for a file.
constexpr std::uint64_t kOfFiles = kReadFile | kWriteFile | kDeviceIoctl;

std::uint64_t AllOfVersion(int version) {
  std::uint64_t all = (std::uint64_t{1} << 14) - 1;  // all of version 2
  if (version >= 3) all |= kTruncate;
  if (version >= 5) all |= kDeviceIoctl;
  return all;
}

Error Refused(const char* what) {
  return {ErrorCode::kUnavailable, "The server could not confine a process to its files.",
          std::string(what) + ": " + std::strerror(errno)};
}

class Ruleset {
 public:
  explicit Ruleset(int version) : all_(AllOfVersion(version)), fd_(Create(version, all_)) {}
  int fd() const { return fd_.get(); }

  Result<void> Allow(const fs::path& path, std::uint64_t rights) const {
    const FileDescriptor at(open(path.c_str(), O_PATH | O_CLOEXEC));
    if (!at.is_open()) return {};
    struct stat what {};
    landlock_path_beneath_attr rule{};
    rule.allowed_access = rights & all_;
    if (fstat(at.get(), &what) == 0 && !S_ISDIR(what.st_mode)) rule.allowed_access &= kOfFiles;
    rule.parent_fd = at.get();
    if (syscall(SYS_landlock_add_rule, fd(), LANDLOCK_RULE_PATH_BENEATH, &rule, 0) != 0)
      return Refused(("landlock_add_rule " + path.string()).c_str());
    return {};
  }

 private:
  static int Create(int version, std::uint64_t all) {
    RulesetAttributes attributes;
    attributes.files = all;
    if (version >= 4) attributes.net = kBindTcp | kConnectTcp;
    if (version >= 6) attributes.scoped = kAbstractSockets | kSignals;
    return static_cast<int>(syscall(SYS_landlock_create_ruleset, &attributes, sizeof(attributes), 0));
  }

  std::uint64_t all_;
  FileDescriptor fd_;
};

Result<void> ConfineFiles(const FileAccess& access) {
  const int version = LandlockVersion();
  if (version == 0) return {};
  const Ruleset ruleset(version);
  if (ruleset.fd() < 0) return Refused("landlock_create_ruleset");
  for (const auto& path : access.reads) SKYQUILT_TRY(ruleset.Allow(path, kRead));
  for (const auto& path : access.writes) SKYQUILT_TRY(ruleset.Allow(path, kWrite));
  SKYQUILT_TRY(ruleset.Allow("/dev/null", kReadFile | kWriteFile));
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return Refused("no_new_privs");
  if (syscall(SYS_landlock_restrict_self, ruleset.fd(), 0) != 0) return Refused("landlock_restrict_self");
  return {};
}

// Nothing of a user's lies there. /usr/bin and /etc are not needed.
constexpr const char* kSystemFiles[] = {
    "/lib",           "/lib32",           "/lib64",           "/usr/lib",
    "/usr/lib32",     "/usr/lib64",       "/usr/libexec",     "/usr/share",
    "/usr/local/lib", "/usr/local/share", "/etc/ld.so.cache", "/etc/localtime",
    "/proc/self",     "/proc/cpuinfo",    "/proc/meminfo",    "/sys/devices/system",
    "/sys/fs/cgroup", "/dev/urandom",     "/dev/random",      "/dev/zero"};
// Where an operator's own PROJ and GDAL have their data; lists with colons.
constexpr const char* kDataVariables[] = {"PROJ_DATA", "PROJ_LIB", "GDAL_DATA"};

void AddSystemFiles(FileAccess& access) {
  access.reads.insert(access.reads.end(), std::begin(kSystemFiles), std::end(kSystemFiles));
  for (const char* variable : kDataVariables) {
    const char* value = std::getenv(variable);
    std::istringstream folders(value == nullptr ? "" : value);
    for (std::string folder; std::getline(folders, folder, ':');) {
      if (fs::path(folder).is_absolute() && folder != "/") access.reads.emplace_back(folder);
    }
  }
}

// ThreadSanitizer has a thread of its own, which decodes nothing.
#if defined(__SANITIZE_THREAD__)
Result<void> RequireOneThread() { return {}; }
#else
Result<void> RequireOneThread() {
  std::error_code unknown;  // no /proc: then nobody can say
  const auto threads =
      std::distance(fs::directory_iterator("/proc/self/task", unknown), fs::directory_iterator());
  if (threads <= 1) return {};
  return Error{
      ErrorCode::kUnavailable,
      "Nothing is decoded on this machine: one of its libraries begins threads as it is loaded, and those "
      "would not be confined. LD_PRELOAD and \"ldd\" of the program show the operator which.",
      std::to_string(threads) + " threads"};
}
#endif

}  // namespace

int LandlockVersion() {
  const long version = syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  return version >= kFirstUsableVersion ? static_cast<int>(version) : 0;
}

void LimitThisProcess(const ProcessLimits& limits) {
  Limit(RLIMIT_CORE, 0);
  if (limits.more_memory_bytes) {
    Limit(RLIMIT_AS, static_cast<rlim_t>(AddressSpaceBytes() + *limits.more_memory_bytes));
  }
  if (limits.more_data_bytes) {
    Limit(RLIMIT_DATA, static_cast<rlim_t>(DataBytes() + *limits.more_data_bytes));
  }
  if (limits.more_cpu_s) {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    Limit(RLIMIT_CPU, static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec + *limits.more_cpu_s),
          kCpuBeyondSignalS);
  }
  if (limits.file_bytes) Limit(RLIMIT_FSIZE, static_cast<rlim_t>(*limits.file_bytes));
}

void StepBack() {
  setpriority(PRIO_PROCESS, 0, 5);
  // Where it cannot be opened this is no Linux as we know it: then without.
  FileDescriptor(open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC)).Write("500", 3);
}

bool FollowParent(int parent, int signal) {
  prctl(PR_SET_PDEATHSIG, signal);
  return getppid() == parent;  // it may have died before the signal was requested
}

Result<void> Confine(FileAccess access) {
  SKYQUILT_TRY(RequireOneThread());
  AddSystemFiles(access);
  SKYQUILT_TRY(ConfineFiles(access));
  return ConfineSystemCalls();
}

Result<void> EnterSandbox(SandboxNeeds needs) {
  StepBack();
  // What is loaded already counts in no limit.
  SKYQUILT_TRY(needs.library.empty() ? LoadLate() : LoadLate({needs.library}));
  LimitThisProcess(needs.limits);
  return Confine(std::move(needs.files));
}

std::string ConfinementHere() {
  const int version = LandlockVersion();
  if (version > 0) return "seccomp and Landlock " + std::to_string(version);
  return "seccomp alone; this kernel offers no Landlock, so that a decoder taken over by a crafted photo could "
         "read and write what this server's user can";
}

}  // namespace skyquilt::server
