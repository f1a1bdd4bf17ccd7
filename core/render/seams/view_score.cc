#include "core/render/seams/view_score.h"

namespace skyquilt::render {
namespace {

// Seams keep off the outer part of a photo: lens fall-off and the worst of the distortion are there.
constexpr float kBorderShare = 0.06f;
// How far a photo gives way at its very border, in heights above ground.
constexpr float kBorderPenaltyHeights = 4.0f;
constexpr float kPoseOnlyPenaltyHeights = 0.3f;
constexpr double kCoarse = 3.0;  // times the ground that the map's pixels show
constexpr float kCoarsePenaltyHeights = 20.0f;

}  // namespace

ViewScore ViewScore::Of(const alignment::AlignedPhoto& photo) {
  ViewScore score;
  score.width_px = static_cast<float>(photo.intrinsics.width_px);
  score.height_px = static_cast<float>(photo.intrinsics.height_px);
  score.taper_px = std::max(1.0f, kBorderShare * std::min(score.width_px, score.height_px));
  score.border_penalty_m =
      kBorderPenaltyHeights * static_cast<float>(std::max(1.0, photo.height_above_ground_m));
  // Of two photos that see a point equally well, the one whose place is known better.
  score.constant_m = static_cast<float>(std::min(photo.error_radius_m, photo.height_above_ground_m));
  // Every seam between an aligned photo and one that is not shows a step: let there be few.
  if (photo.placement == alignment::Placement::kPoseOnly) {
    score.constant_m += kPoseOnlyPenaltyHeights * static_cast<float>(photo.height_above_ground_m);
  }
  score.coarse_penalty_m =
      kCoarsePenaltyHeights * static_cast<float>(std::max(1.0, photo.height_above_ground_m));
  return score;
}

float ViewScore::CoarsePenalty(const Eigen::Vector3d& offset_m, double focal_px, double map_gsd_m) const {
  // Along its ray a pixel is drawn out by the look angle.
  const double gsd_m = offset_m.squaredNorm() / (focal_px * std::max(1e-3, -offset_m.z()));
  const double times = gsd_m / (kCoarse * map_gsd_m);
  return times > 1.0 ? coarse_penalty_m * static_cast<float>(times) : 0.0f;
}

}  // namespace skyquilt::render
