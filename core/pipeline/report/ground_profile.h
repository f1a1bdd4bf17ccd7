// ProfileGround: the height of the ground along a line, as a finished map was rendered (core/pipeline/report/
// locate): samples at even steps on each part of the line, its corners among them. Between two corners the
// line is straight in longitude and latitude. Lengths along the ellipsoid, by chords of a step, each short by
// 4e-11 of itself at a step of 200 m. Heights are those of GroundAt: metres above the ellipsoid as the
// flight's records have it. Pure; any thread; the time and memory of kMaxProfileSamples samples. Errors:
// kUnprocessable (a line of one place or too many, or too long).
#pragma once

#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/geo/lat_lon.h"
#include "core/geo/lat_lon_bounds.h"
#include "core/pipeline/report/locate.h"

namespace skyquilt::pipeline {

inline constexpr std::size_t kMaxProfileCorners = 500;
inline constexpr std::size_t kMaxProfileSamples = 1000;  // besides the corners

struct ProfileSample {
  double distance_m = 0.0;  // from the line's beginning
  geo::LatLon position;
  std::optional<double> height_m;  // nothing: the map knows no ground there
};

struct GroundProfile {
  std::vector<ProfileSample> samples;  // in the order of the line
  double length_m = 0.0;
  double step_m = 0.0;  // the longest between two samples
  // Of the samples that have a height; nothing where none has.
  std::optional<double> lowest_m, highest_m;
  double climb_m = 0.0, descent_m = 0.0;  // the sums of what goes up and of what goes down
};

// `bounds`: of the map. Beyond them, and beyond the ground's grid, nothing is known.
Result<GroundProfile> ProfileGround(const LocatedMap& map, const geo::LatLonBounds& bounds,
                                    const std::vector<geo::LatLon>& line);

}  // namespace skyquilt::pipeline
