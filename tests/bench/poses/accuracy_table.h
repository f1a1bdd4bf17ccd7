// Prints the accuracy of the smoother for each mix of inputs beside its reference figures.
#pragma once

#include <string>

namespace skyquilt::bench {
// Only rows whose name begins with `only`; all where it is empty.
void PrintAccuracyTable(int seeds, const std::string& only);
}  // namespace skyquilt::bench
