// MoveToControl: a finished flight brought to one to four surveyed points as a whole, so that none of its
// photos is compared again: shifted, and turned and stretched about the vertical where points that lie far
// enough apart say so. Heights keep their zero: survey and drone seldom share it. Nothing comes back where
// that will not do: more points, or points that a flight can only be bent to; then it is better aligned anew.
// Pure; any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/flight/logs/texts/gcp_list.h"
#include "core/pipeline/report/flight_facts.h"

namespace skyquilt::pipeline {

// `known` is a flight aligned by features, with the photos' names. What comes back has no appearance: its
// seams lie elsewhere on the map now.
std::optional<FlightFacts> MoveToControl(const FlightFacts& known, const std::vector<flight::GcpList>& lists);

}  // namespace skyquilt::pipeline
