#include "core/camera/rolling_shutter.h"

#include <algorithm>
#include <cmath>

namespace skyquilt::camera {
namespace {

// Which row sees the point depends on how the camera stood, and that on the row: each step is nearer by the
// factor by which the camera is slower than its rows.
constexpr int kStepsOfShift = 3;
constexpr int kMaxSteps = 20;
constexpr double kSettledPx = 1e-3;

}  // namespace

Eigen::Quaterniond RowMotion::TurnAt(double share) const {
  if (turns_rad.empty()) return Eigen::Quaterniond::Identity();
  const auto last = static_cast<double>(turns_rad.size() - 1);
  const double at = std::clamp((share + 0.5) * last, 0.0, last);
  const auto before = static_cast<std::size_t>(at);
  const std::size_t after = std::min(before + 1, turns_rad.size() - 1);
  const double weight = at - static_cast<double>(before);
  return geo::RotationFromVector((1.0 - weight) * turns_rad[before] + weight * turns_rad[after]);
}

geo::Rigid3 PoseAtRow(const geo::Rigid3& cam_from_enu, const RowMotion& motion, double y_px, int height_px) {
  geo::Rigid3 there = cam_from_enu;
  const double share = RowShare(y_px, height_px);
  there.translation -= share * (cam_from_enu.rotation * motion.shift_in_enu_m);
  if (motion.turns_rad.empty()) return there;
  const Eigen::Quaterniond row_from_middle = motion.TurnAt(share);
  return {(row_from_middle * there.rotation).normalized(), row_from_middle * there.translation};
}

std::optional<Eigen::Vector2d> ProjectRolling(const Intrinsics& lens, const geo::Rigid3& cam_from_enu,
                                              const RowMotion& motion, const Eigen::Vector3d& point_in_enu) {
  std::optional<Eigen::Vector2d> pixel = lens.Project(cam_from_enu * point_in_enu);
  if (motion.IsStill()) return pixel;
  if (motion.turns_rad.empty()) {
    for (int step = 0; pixel && step < kStepsOfShift; ++step) {
      pixel = lens.Project(PoseAtRow(cam_from_enu, motion, pixel->y(), lens.height_px) * point_in_enu);
    }
    return pixel;
  }
  // The middle row may look past a point that an outer one sees.
  double row_px = pixel ? pixel->y() : 0.5 * (lens.height_px - 1);
  for (int step = 0; step < kMaxSteps; ++step) {
    pixel = lens.Project(PoseAtRow(cam_from_enu, motion, row_px, lens.height_px) * point_in_enu);
    if (!pixel || std::abs(pixel->y() - row_px) < kSettledPx) return pixel;
    row_px = pixel->y();
  }
  return std::nullopt;
}

}  // namespace skyquilt::camera
