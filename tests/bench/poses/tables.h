// The tables that bench_poses prints, each in a source of its name.
#pragma once

#include <string>

namespace skyquilt::bench {

// The accuracy of the smoother for each mix of inputs beside its reference figures. Only rows whose name
// begins with `only`; all where it is empty.
void PrintAccuracyTable(int seeds, const std::string& only);

// What trapezoid and Simpson's rule make of exact, aliased and noisy inertial samples.
void PrintIntegrationTable(int seeds);

// The errors of a 75 s hop at 20 m without GNSS, from a take-off marker: the flight that Iz and Unel
// describe.
void PrintPaperHop(int seeds);

// The drift of dead reckoning on real flight logs, and how far the smoother strays when GNSS fixes are taken
// away for a while. Every .bin and .ulg log of a folder; says so where there is none.
void PrintRealLogs(const std::string& folder);

}  // namespace skyquilt::bench
