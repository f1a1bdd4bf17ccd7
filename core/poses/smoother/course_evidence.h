// JudgeCourse: what a flight's course says of its recorded headings. A nose that keeps to the course shows
// where the compass errs; how well it keeps to it is measured on the flight itself, by how far recorded
// headings and courses lie apart where the flight runs straight. Flights sideways, and small aircraft that
// crab in the wind, give no evidence. Radians, metres, seconds, enu. Pure; any thread.
#pragma once

#include <optional>
#include <vector>

#include "core/poses/smoother/chain_state.h"

namespace skyquilt::poses {

struct CourseEvidence {
  double sigma_rad = 0.0;           // of the nose against the course, a slow error
  std::vector<bool> runs_straight;  // one per knot: fast enough and turning neither way nor nose
};

// knots: headings as recorded. Nothing where fewer than 10 knots run straight or the nose does not keep to
// the course.
std::optional<CourseEvidence> JudgeCourse(const std::vector<KnotState>& knots,
                                          const std::vector<double>& times_s, double min_speed_mps);

}  // namespace skyquilt::poses
