#include "core/alignment/align_by_pose.h"

#include "core/alignment/bundle/readout_motion.h"

namespace skyquilt::alignment {

AlignedFlight WithoutPhotos(const poses::PosedFlight& posed) {
  AlignedFlight aligned;
  aligned.frame = posed.frame;
  aligned.ground_z_in_enu_m = posed.ground_z_in_enu_m;
  aligned.left_out = posed.left_out;
  aligned.warnings = posed.warnings;
  return aligned;
}

AlignedFlight AlignByPoseOnly(const poses::PosedFlight& posed) {
  AlignedFlight aligned = WithoutPhotos(posed);
  const std::vector<flight::Remark> assumed = poses::AssumptionsByPoses(posed.assumptions);
  aligned.warnings.insert(aligned.warnings.end(), assumed.begin(), assumed.end());
  aligned.photos.reserve(posed.photos.size());
  for (const poses::PosedPhoto& photo : posed.photos) {
    aligned.photos.push_back({.photo = photo.photo,
                              .intrinsics = photo.photo.intrinsics,
                              .cam_from_enu = photo.cam_from_enu,
                              .readout_motion = ReadoutMotion(photo, 0),
                              .placement = Placement::kPoseOnly,
                              .placement_remarks = {flight::RemarkCode::kByPoseAlone},
                              .error_radius_m = photo.error_radius_m,
                              .height_above_ground_m = photo.height_above_ground_m,
                              .sharpness = {}});
  }
  return aligned;
}

const char* PlacementName(Placement placement) {
  return placement == Placement::kAligned ? "aligned" : "pose_only";
}

}  // namespace skyquilt::alignment
