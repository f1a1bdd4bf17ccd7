#include "server/process_limits.h"

#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

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

}  // namespace

void LimitThisProcess(const ProcessLimits& limits) {
  Limit(RLIMIT_CORE, 0, true);
  if (limits.more_memory_bytes) {
    Limit(RLIMIT_AS, static_cast<rlim_t>(AddressSpaceBytes() + *limits.more_memory_bytes), true);
  }
  if (limits.more_cpu_s) {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    Limit(RLIMIT_CPU, static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec + *limits.more_cpu_s),
          false);
  }
  if (limits.file_bytes) Limit(RLIMIT_FSIZE, static_cast<rlim_t>(*limits.file_bytes), true);
}

bool FollowParent(int parent, int signal) {
  prctl(PR_SET_PDEATHSIG, signal);
  return getppid() == parent;  // it may have died before we asked to be told
}

}  // namespace skyquilt::server
