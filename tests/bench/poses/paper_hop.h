// Prints the errors of a 75 s hop at 20 m without GNSS, from a take-off marker: the flight that Iz and Unel
// describe.
#pragma once

namespace skyquilt::bench {
void PrintPaperHop(int seeds);
}  // namespace skyquilt::bench
