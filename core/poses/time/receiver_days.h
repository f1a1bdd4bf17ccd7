// WhyOfAnotherDay: photos whose time a receiver of GNSS told need no shift to a log that knows UTC; one that
// takes hours or days to fit is of another flight, however well its rhythm fits (a mission that is flown
// every week). Pure; any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"
#include "core/poses/time/time_sync.h"

namespace skyquilt::poses {

// Why `sync` cannot be true; nothing where it can, or where nobody knows.
std::optional<flight::Remark> WhyOfAnotherDay(const std::vector<flight::Photo>& photos,
                                              const flight::FlightLog& log, const TimeSync& sync);

}  // namespace skyquilt::poses
