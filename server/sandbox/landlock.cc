#include "server/sandbox/landlock.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>

namespace skyquilt::server {
namespace {

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
  explicit Ruleset(int version) : all_(AllOfVersion(version)) {
    RulesetAttributes attributes;
    attributes.files = all_;
    if (version >= 4) attributes.net = kBindTcp | kConnectTcp;
    if (version >= 6) attributes.scoped = kAbstractSockets | kSignals;
    fd_ = static_cast<int>(syscall(SYS_landlock_create_ruleset, &attributes, sizeof(attributes), 0));
  }
  ~Ruleset() {
    if (fd_ >= 0) close(fd_);
  }
  Ruleset(const Ruleset&) = delete;
  Ruleset& operator=(const Ruleset&) = delete;
  int fd() const { return fd_; }

  Result<void> Allow(const std::filesystem::path& path, std::uint64_t rights) const {
    const int at = open(path.c_str(), O_PATH | O_CLOEXEC);
    if (at < 0) return {};
    struct stat what {};
    landlock_path_beneath_attr rule{};
    rule.allowed_access = rights & all_;
    if (fstat(at, &what) == 0 && !S_ISDIR(what.st_mode)) rule.allowed_access &= kOfFiles;
    rule.parent_fd = at;
    const long failed = syscall(SYS_landlock_add_rule, fd_, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
    const int code = errno;
    close(at);
    errno = code;
    if (failed != 0) return Refused(("landlock_add_rule " + path.string()).c_str());
    return {};
  }

 private:
  std::uint64_t all_;
  int fd_ = -1;
};

}  // namespace

int LandlockVersion() {
  const long version = syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  return version >= kFirstUsableVersion ? static_cast<int>(version) : 0;
}

Result<void> ConfineFiles(const FileAccess& access) {
  const int version = LandlockVersion();
  if (version == 0) return {};
  const Ruleset ruleset(version);
  if (ruleset.fd() < 0) return Refused("landlock_create_ruleset");
  for (const auto& path : access.reads) {
    if (auto allowed = ruleset.Allow(path, kRead); !allowed) return allowed;
  }
  for (const auto& path : access.writes) {
    if (auto allowed = ruleset.Allow(path, kWrite); !allowed) return allowed;
  }
  if (auto allowed = ruleset.Allow("/dev/null", kReadFile | kWriteFile); !allowed) return allowed;
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return Refused("no_new_privs");
  if (syscall(SYS_landlock_restrict_self, ruleset.fd(), 0) != 0) return Refused("landlock_restrict_self");
  return {};
}

}  // namespace skyquilt::server
