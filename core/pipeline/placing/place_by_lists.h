// A finished flight brought to the surveyed points among its files. No photo is compared again. Frame `enu`
// of the flight, which may change. Pure; any thread. Errors, whole sentences for the user: kUnprocessable (no
// point that can be used; points that lie too near together, or contradict each other).
#pragma once

#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "core/pipeline/report/flight_facts.h"

namespace skyquilt::pipeline {

// To one to four points as a whole: shifted, and turned and stretched about the vertical where points that
// lie far enough apart say so. Heights keep their zero: survey and drone seldom share it. Nothing comes back
// where that will not do: more points, points that a flight can only be bent to, or that would turn or
// stretch one whose positions are corrected; then it is better aligned anew. `known` is a flight aligned by
// features, with the photos' names. What comes back has no appearance: its seams lie elsewhere on the map
// now.
std::optional<FlightFacts> MoveToControl(const FlightFacts& known, const std::vector<flight::GcpList>& lists);

// Wherever the flight lies now: as MoveToControl does where one to four points suffice, else by all of them
// as PlaceKnown does. What earlier runs said of surveyed points is said anew. Check points alone leave it
// where it is, unless surveyed points put it there. `contradict`: as of PlaceKnown.
Result<FlightFacts> PlaceByLists(FlightFacts known, const std::vector<flight::GcpList>& lists,
                                 bool* contradict = nullptr);

// How far each mark of a surveyed point lies from where the placed map has the point, and how far the
// survey's zero of heights lies from the map's. Nothing is said where the map has no place, or no figures of
// its alignment. Where points of none of these lists place it (`skyquilt place --gcp`), what was told of
// these stays.
void TellMarks(const std::vector<flight::GcpList>& lists, FlightFacts& facts);

}  // namespace skyquilt::pipeline
