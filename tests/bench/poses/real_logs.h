// Prints the drift of dead reckoning on real flight logs, and how far the smoother strays when GNSS fixes are
// taken away for a while.
#pragma once

#include <string>

namespace skyquilt::bench {
// Every .bin and .ulg log of a folder; says so where there is none.
void PrintRealLogs(const std::string& folder);
}  // namespace skyquilt::bench
