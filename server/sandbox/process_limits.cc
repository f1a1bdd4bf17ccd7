#include "server/sandbox/process_limits.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <string>

namespace skyquilt::server {
namespace {

// RLIMIT_CPU's signal is sent at the soft limit; the hard one stays where it was, so that it can be moved on.
void Limit(int resource, rlim_t soft, bool is_final) {
  rlimit limit{};
  getrlimit(static_cast<__rlimit_resource>(resource), &limit);
  limit.rlim_cur = soft < limit.rlim_max ? soft : limit.rlim_max;
  if (is_final) limit.rlim_max = limit.rlim_cur;
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

}  // namespace

void LimitThisProcess(const ProcessLimits& limits) {
  Limit(RLIMIT_CORE, 0, true);
  if (limits.more_memory_bytes) {
    Limit(RLIMIT_AS, static_cast<rlim_t>(AddressSpaceBytes() + *limits.more_memory_bytes), true);
  }
  if (limits.more_data_bytes) {
    Limit(RLIMIT_DATA, static_cast<rlim_t>(DataBytes() + *limits.more_data_bytes), true);
  }
  if (limits.more_cpu_s) {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    Limit(RLIMIT_CPU, static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec + *limits.more_cpu_s),
          false);
  }
  if (limits.file_bytes) Limit(RLIMIT_FSIZE, static_cast<rlim_t>(*limits.file_bytes), true);
}

void StepBack() {
  setpriority(PRIO_PROCESS, 0, 5);
  const int fd = open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
  if (fd < 0) return;  // not Linux as we know it: then without
  [[maybe_unused]] const ssize_t wrote = write(fd, "500", 3);
  close(fd);
}

bool FollowParent(int parent, int signal) {
  prctl(PR_SET_PDEATHSIG, signal);
  return getppid() == parent;  // it may have died before the signal was requested
}

}  // namespace skyquilt::server
