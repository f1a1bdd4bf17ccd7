// PeakMib: the most memory that this process has held so far. It never falls: what lies between two calls
// took no more than the difference where that is above zero.
#pragma once

#include <sys/resource.h>

namespace skyquilt::test {

inline double PeakMib() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return static_cast<double>(used.ru_maxrss) / 1024.0;
}

}  // namespace skyquilt::test
