// ChooseConvention: which reading of the recorded camera angles fits the flight. Makers differ in where pitch
// is zero, which way it counts, and whether angles are the camera's or the airframe's; a reading is scored by
// whether photos see the ground and whether neighbours see the same ground, as a mapping flight's do. Another
// reading than the recorded one is taken only where that one fails and the other plainly holds. Headings are
// compared with the course and with the log's airframe and reported, never changed: surveys fly sideways, and
// only pictures tell a turned mount. Radians. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/flight/photo.h"

namespace skyquilt::poses {

struct ConventionChoice {
  std::string words;        // for the report; empty where no photo has angles
  bool is_changed = false;  // another reading than the recorded one was taken
};

// Changes the angles of `photos` where another reading was chosen. airframe_yaw_rad: by the log, one per
// photo or empty.
ConventionChoice ChooseConvention(std::vector<flight::Photo>& photos,
                                  const std::vector<std::optional<double>>& airframe_yaw_rad);

}  // namespace skyquilt::poses
