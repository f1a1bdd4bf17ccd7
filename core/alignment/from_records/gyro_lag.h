// TieGyrosToRows: whether cameras turned while they read their rows as their gyros say, and by how much these
// lag (filters delay them, and clocks are tied loosely): the ground as two photos show it differs by one
// projective map, more or less, once each row is turned to where the middle one looked. Of all lags the one
// at which most matches fit. A record that fits worse than none is taken out of its photos. Deterministic;
// any number of threads. Method: Karpenko and others (2011), by counting instead of descent.
#pragma once

#include <vector>

#include "core/alignment/scene/align_report.h"
#include "core/alignment/scene/keypoints.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// A report for each camera with a gyro. Shifts the samples' times in `posed` by the lag found; leaves them
// where the photos do not tell. features: nothing for photos that cannot be read.
std::vector<GyroReport> TieGyrosToRows(poses::PosedFlight& posed,
                                       const std::vector<const PhotoFeatures*>& features, int threads);

}  // namespace skyquilt::alignment
