// The processor seconds that were taken so far: by the calling thread, and by all of the program.
#pragma once

#include <sys/resource.h>

namespace skyquilt {

inline double CpuSecondsOf(int who) {
  rusage usage{};
  getrusage(who, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}
inline double ThreadCpuSeconds() { return CpuSecondsOf(RUSAGE_THREAD); }
inline double CpuSeconds() { return CpuSecondsOf(RUSAGE_SELF); }

}  // namespace skyquilt
