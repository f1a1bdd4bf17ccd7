// PeakMib: the most memory that this process has held so far. It never falls: what lies between two calls
// took no more than the difference where that is above zero. AddressSanitizer keeps what was freed: 0 there.
#pragma once

#include <sys/resource.h>

namespace skyquilt::test {

inline double PeakMib() {
#ifdef __SANITIZE_ADDRESS__
  return 0.0;
#else
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return static_cast<double>(used.ru_maxrss) / 1024.0;
#endif
}

}  // namespace skyquilt::test
