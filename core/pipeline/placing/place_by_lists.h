// PlaceByLists: a finished flight brought to the surveyed points among its files, wherever it lies now:
// shifted (and turned and stretched a little) as MoveToControl does where one to four points suffice, else
// placed by all of them as PlaceKnown does. No photo is compared again. What earlier runs said of surveyed
// points is said anew. TellMarks: how far each mark of a surveyed point lies from where the placed map has
// the point. Frame `enu` of the flight, which may change. Pure; any thread. Errors, whole sentences for the
// user: kUnprocessable (no point that can be used; points that lie too near together, or contradict each
// other).
#pragma once

#include <vector>

#include "core/base/result.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "core/pipeline/report/flight_facts.h"

namespace skyquilt::pipeline {

// `contradict`: as of PlaceKnown.
Result<FlightFacts> PlaceByLists(FlightFacts known, const std::vector<flight::GcpList>& lists,
                                 bool* contradict = nullptr);

// Nothing is said where the map has no place, or no figures of its alignment.
void TellMarks(const std::vector<flight::GcpList>& lists, FlightFacts& facts);

}  // namespace skyquilt::pipeline
