// AlignByPoseOnly: the map of the flight recorder alone: every photo is placed where the estimated pose says,
// no pixel looked at. The way of Iz and Unel's pose-based mosaics, the preview, and what AlignFlight falls
// back to. Pure; any thread; cannot fail.
#pragma once

#include "core/alignment/scene/aligned_flight.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

// The flight before any photo has its place, and before it is told what became of its assumptions.
AlignedFlight WithoutPhotos(const poses::PosedFlight& posed);

AlignedFlight AlignByPoseOnly(const poses::PosedFlight& posed);

}  // namespace skyquilt::alignment
