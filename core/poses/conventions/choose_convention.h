// ChooseConvention: which reading of the recorded camera angles fits the flight. Makers differ in where pitch
// is zero, which way it counts, and whether angles are the camera's or the airframe's; a reading is scored by
// whether photos see the ground and whether neighbours see the same ground, as a mapping flight's do. Another
// reading than the recorded one is taken only where that one fails and the other plainly holds, for each
// maker of a mixed fleet on its own. Headings are compared with the course and with the log's airframe and
// reported, never changed: surveys fly sideways, and only pictures tell a turned mount. CoursesFromPositions:
// that course. Radians. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/flight/photo.h"

namespace skyquilt::poses {

// The course over ground of each photo, clockwise from north, from the positions of its neighbours in time:
// what stands in for a yaw that is not recorded. positions: (E, N) in the order of capture. A turn between
// two photos belongs to neither: at a line's end the course of the straight run is taken. Nothing for a photo
// without any neighbour further than 1 m.
std::vector<std::optional<double>> CoursesFromPositions(const std::vector<Eigen::Vector2d>& positions_in_enu);
// The same where several cameras took them, cameras[i] being that of a photo: a camera goes by itself where
// its steps are clearly shorter so. Two clocks, or two aircraft, mix photos of different places.
std::vector<std::optional<double>> CoursesOfCameras(const std::vector<std::string_view>& cameras,
                                                    const std::vector<Eigen::Vector2d>& positions_in_enu);

struct ConventionChoice {
  std::string words;        // for the report; empty where no photo has angles
  bool is_changed = false;  // another reading than the recorded one was taken
};

// Changes the angles of `photos` where another reading was chosen. airframe_yaw_rad: by the log, or empty.
ConventionChoice ChooseConvention(std::vector<flight::Photo>& photos,
                                  const std::vector<std::optional<double>>& airframe_yaw_rad);

}  // namespace skyquilt::poses
