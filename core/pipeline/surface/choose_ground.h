// ChooseGround: whether --surface auto lays photos on heights of every cell or on the smooth ground: on
// heights where what stands on the ground leans by more than two pixels, and three photos see most of it.
// Frame enu. Needs the tie points of an alignment, so it is asked once, when a flight is placed; what came of
// it is kept. Any thread; the same on any processor. Without tie points nothing leans.
#pragma once

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/pipeline/report/ground_choice.h"

namespace skyquilt::pipeline {

// That see a place, for its height to be sure.
inline constexpr int kPhotosThatBearOut = 3;

GroundChoice ChooseGround(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground);

}  // namespace skyquilt::pipeline
