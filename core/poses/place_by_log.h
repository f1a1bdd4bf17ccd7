// PlaceByLog: photos whose times on a log's clock are known, placed by the smoothed chain of the log's series
// and of what the photos record. PlaceCameras: the cameras on that chain. Frames: `enu` of the flight, z = 0
// at take-off, `body`, `cam`. Pure; any thread. Fails with kUnprocessable where the series do not fix a track
// (the message says what to add).
#pragma once

#include <vector>

#include "core/base/result.h"
#include "core/geo/local_frame.h"
#include "core/poses/evidence/smoother_input.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::poses {

// One pose per photo, without the photo itself: the camera in the body, or its own recorded rotation where a
// gimbal held it, turned by the attitude system's error. `ground_z_in_enu_m`: the plane for height and error.
std::vector<PosedPhoto> PlaceCameras(const PreparedSmoothing& prepared, const SmootherOutput& smoothed,
                                     double ground_z_in_enu_m);

struct PlacedByLog {
  std::vector<PosedPhoto> photos;  // in the order of those given
  bool is_placed = true;           // false: reckoned from the frame's origin, which nothing placed
  std::vector<std::string> series;
  SmootherReport smoothing;
};

// `sources` has a log, `ground_z_in_enu_m` as above.
Result<PlacedByLog> PlaceByLog(const FlightSources& sources, const geo::LocalFrame& frame,
                               double ground_z_in_enu_m);

}  // namespace skyquilt::poses
