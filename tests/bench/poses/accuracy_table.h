// Prints the accuracy of the smoother for each mix of inputs beside its reference figures.
#pragma once

namespace skyquilt::bench {
void PrintAccuracyTable(int seeds);
}  // namespace skyquilt::bench
