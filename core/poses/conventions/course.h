// Course over ground of each photo from the positions of its neighbours in time: what stands in for the yaw
// of a photo that recorded none. Radians clockwise from north. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace skyquilt::poses {

// positions: (E, N) in the order of capture. A turn between two photos belongs to neither: at a line's end
// the course of the straight run is taken. Nothing for a photo without any neighbour further than 1 m.
std::vector<std::optional<double>> CoursesFromPositions(const std::vector<Eigen::Vector2d>& positions_in_enu);

}  // namespace skyquilt::poses
