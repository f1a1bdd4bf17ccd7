// ControlPointsOf: the ground control points of a flight (ODM's gcp_list format) as the alignment wants them.
// Points that are marked in no photo are not among them. None is not an error. Pure; any thread.
#pragma once

#include <vector>

#include "core/alignment/scene/ground_control.h"
#include "core/flight/logs/texts/gcp_list.h"

namespace skyquilt::pipeline {

std::vector<alignment::ControlPoint> ControlPointsOf(const std::vector<flight::GcpList>& lists);

// Those that are named check points: compared with the finished map, which they do not place.
std::vector<alignment::ControlPoint> CheckPointsOf(const std::vector<flight::GcpList>& lists);

}  // namespace skyquilt::pipeline
