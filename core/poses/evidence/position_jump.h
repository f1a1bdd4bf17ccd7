// JumpOf: where a flight's recorded positions, in the order in which they were taken, begin to lie elsewhere
// than those before: of a receiver that lost its fix and found another, of a base that was set up anew.
// Within each part they agree to what they claim, so a map that follows them bends at the jump and is missed
// by little; but all photos of one side lie off by it, and the photos do not tell which. `misses`: recorded
// minus as adjusted, metres of two horizontal axes. Nothing where no jump is some times what positions claim
// and what they change by from one to the next.
//
// HeightJumpOf: the same of heights, of which photos from above tell less. A tilt and a bend of the whole are
// taken off first; what a wrong scale makes of a climb is no jump, nor is a step that does not stand out of
// the others, as at the turns of a map that bends otherwise. Where too little tells the two apart, as at a
// turn among four lines, nothing is found. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

namespace skyquilt::poses {

struct PositionJump {
  std::size_t last_before = 0;  // index of the position
  double by_m = 0.0;  // between the medians of three on either side; where the map bends it hides a part
};

std::optional<PositionJump> JumpOf(const std::vector<Eigen::Vector2d>& misses, double claimed_m);

// `misses_m`: recorded minus as adjusted, up, one for each camera.
std::optional<PositionJump> HeightJumpOf(const std::vector<Eigen::Vector3d>& cameras_in_enu,
                                         const std::vector<double>& misses_m, double claimed_m);

}  // namespace skyquilt::poses
