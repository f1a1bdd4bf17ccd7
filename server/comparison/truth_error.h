// MeasureTruthError: how far the pixels of a finished map's photos lie from their true place, for flights
// that `simulate` made: pixels of every photo are projected to the map's ground and to the true one. Objects
// above the ground (buildings) are not part of it. Pure. Errors: kCorrupt (not the simulator's truth),
// kUnprocessable (the truth of other photos).
#pragma once

#include <string_view>

#include "core/base/result.h"
#include "core/pipeline/report/locate.h"

namespace skyquilt::server {

struct TruthError {
  int photos = 0;                // of the map that the truth knows
  int photos_true = 0;           // that the truth knows in all
  double absolute_ce90_m = 0.0;  // nine of ten pixels lie nearer to their place than this
  double relative_ce90_m = 0.0;  // after the best shift, turn and scale of the whole map
  double worst_photo_m = 0.0;    // largest median error of one photo, absolute
};

// `truth_json`: truth/poses.json of the simulator.
Result<TruthError> MeasureTruthError(const pipeline::LocatedMap& map, std::string_view truth_json);

}  // namespace skyquilt::server
