// Surveyed points of a flight (ODM's gcp_list format) as alignment and API want them. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/scene/ground_control.h"
#include "core/flight/logs/texts/gcp_list.h"

namespace skyquilt::pipeline {

// Those that place the map. Points that are marked in no photo are not among them. None is not an error.
std::vector<alignment::ControlPoint> ControlPointsOf(const std::vector<flight::GcpList>& lists);

// Those that are named check points: compared with the finished map, which they do not place.
std::vector<alignment::ControlPoint> CheckPointsOf(const std::vector<flight::GcpList>& lists);

// A list and its marks as the API's JSON (api/openapi.json, ControlPoints). Pixels count from the middle of
// the first one there, from its corner in the list.
std::string ControlJson(const flight::GcpList& list);

}  // namespace skyquilt::pipeline
