// FindWrittenStep: the step in which all coordinates of a list are written, as far as steps of 1e-5 degrees
// or a centimetre: no row is better than it, whatever the list says of itself. In the unit of the rows. Pure;
// any thread. Cost: n log n of the rows.
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

// Likewise of the fixes of a track in degrees: the step in metres; nothing where none claimed a better place.
std::optional<double> WidenToStep(std::vector<flight::GnssSample>& fixes);

}  // namespace skyquilt::poses
