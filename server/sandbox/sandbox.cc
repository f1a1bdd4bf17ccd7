#include "server/sandbox/sandbox.h"

#include <cstdlib>
#include <iterator>
#include <sstream>
#include <string>

#include "server/sandbox/system_calls.h"

namespace skyquilt::server {
namespace {

namespace fs = std::filesystem;

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

Result<void> Confine(FileAccess access) {
  if (auto alone = RequireOneThread(); !alone) return alone;
  AddSystemFiles(access);
  if (auto files = ConfineFiles(access); !files) return files;
  return ConfineSystemCalls();
}

std::string ConfinementHere() {
  const int version = LandlockVersion();
  if (version > 0) return "seccomp and Landlock " + std::to_string(version);
  return "seccomp alone; this kernel offers no Landlock, so that a decoder taken over by a crafted photo could "
         "read and write what this server's user can";
}

}  // namespace skyquilt::server
