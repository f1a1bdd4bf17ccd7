// MoveByPairs: by what turn, scale and shift a finished map comes to where things that it shows really are.
// One pair shifts it; two or more also turn and scale it, by least squares. Heights stay as they are above
// the ground. Frame `enu` of the flight before, a frame at the first true place after. Pure; any thread.
// Errors, whole sentences for the user: kUnprocessable (pairs that lie too near together, or contradict each
// other). Source: the similarity of the plane as one complex factor and shift.
#pragma once

#include <vector>

#include "core/alignment/estimators/similarity.h"
#include "core/base/result.h"
#include "core/geo/local_frame.h"
#include "core/pipeline/placing/place_request.h"
#include "core/pipeline/report/flight_facts.h"

namespace skyquilt::pipeline {

struct MoveOfPairs {
  alignment::Similarity3 new_from_old;
  geo::LocalFrame frame;
  double miss_m = 0.0;  // what the worst pair is missed by; 0 of one or two, which fit anything
};

// pairs: one or more.
Result<MoveOfPairs> MoveByPairs(const FlightFacts& known, const std::vector<ShownPair>& pairs);

}  // namespace skyquilt::pipeline
