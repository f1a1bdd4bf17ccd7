// Prints what trapezoid and Simpson's rule make of exact, aliased and noisy inertial samples.
#pragma once

namespace skyquilt::bench {
void PrintIntegrationTable(int seeds);
}  // namespace skyquilt::bench
