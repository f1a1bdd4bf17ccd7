// FindWrittenStep: the step in which all coordinates of a list are written, where it is coarser than what is
// known of places by good receivers: no row is better than it, whatever the list says of itself. In the unit
// of the rows. Pure; any thread. Cost: n log n of the rows.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/logs/flight_log.h"

namespace skyquilt::poses {

// Nothing of few different numbers, which may be round by chance. `are_degrees`: whole minutes and seconds,
// and decimals of them, count too.
std::optional<double> FindWrittenStep(const std::vector<flight::WrittenPlace>& rows, bool are_degrees);

// One sigma of a number that was rounded.
double SigmaOfStep(double step);

// Of an event the sigma that it then has, and no word for a corrected position, where it claims a better one.
// Whether it did.
bool WidenToStep(double step_m, flight::CameraEvent& event);

}  // namespace skyquilt::poses
