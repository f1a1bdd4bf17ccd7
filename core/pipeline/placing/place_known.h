// PlaceKnown: a finished flight that lies nowhere on Earth brought to where a user says it lies: by one place
// with scale and north, by where things that it shows really are (of any map: one shifts it, more turn and
// scale it too), or by three or more surveyed points marked in its photos (turn, scale, shift, and tilt where
// the points have heights). No photo is compared again. Frame `enu` of the flight, which changes. Pure; any
// thread. Errors, whole sentences for the user: kConflict (it has its place already), kInvalidArgument (a
// number out of range, an unknown photo), kUnprocessable (points that too few photos show, that lie too near
// together, or that contradict each other).
#pragma once

#include "core/base/result.h"
#include "core/pipeline/placing/place_request.h"
#include "core/pipeline/report/flight_facts.h"

namespace skyquilt::pipeline {

// What placed it last is said, and not what did before. `contradict`, where given: becomes true where points
// are refused that no turn, scale and shift fits.
Result<FlightFacts> PlaceKnown(FlightFacts known, const PlaceRequest& request, bool* contradict = nullptr);

// Brings a flight that was aligned anew, with other photos too, to where somebody had placed it before.
// False: too few photos are of both for that, or these do not lie to each other as they did.
bool KeepPlaceByHand(const FlightFacts& placed_by_hand, FlightFacts& anew);

}  // namespace skyquilt::pipeline
