#include "core/alignment/align_by_pose.h"

#include <gtest/gtest.h>

namespace skyquilt::alignment {
namespace {

TEST(AlignByPoseOnly, KeepsEveryPhotoAtItsEstimatedPose) {
  poses::PosedFlight posed;
  posed.ground_z_in_enu_m = 3.5;
  posed.left_out.push_back({.name = "broken.jpg", .reason = "cut off"});
  for (int i = 0; i < 3; ++i) {
    poses::PosedPhoto photo;
    photo.photo.name = "p" + std::to_string(i) + ".jpg";
    photo.photo.intrinsics = camera::Intrinsics::Centered(400, 300, 350.0 + i);
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0),
                                                                  Eigen::Vector3d(10.0 * i, 20.0, 50.0));
    photo.error_radius_m = 1.0 + i;
    photo.height_above_ground_m = 46.5;
    posed.photos.push_back(photo);
  }
  const AlignedFlight aligned = AlignByPoseOnly(posed);
  ASSERT_EQ(aligned.photos.size(), 3u);
  EXPECT_EQ(aligned.ground_z_in_enu_m, 3.5);
  ASSERT_EQ(aligned.left_out.size(), 1u);
  EXPECT_TRUE(aligned.tie_points_in_enu.empty());
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(aligned.photos[i].photo.name, posed.photos[i].photo.name);
    EXPECT_EQ(aligned.photos[i].intrinsics, posed.photos[i].photo.intrinsics);
    EXPECT_EQ(aligned.photos[i].placement, Placement::kPoseOnly);
    EXPECT_EQ(aligned.photos[i].placement_remarks,
              std::vector<flight::Remark>{flight::RemarkCode::kByPoseAlone});
    EXPECT_EQ(aligned.photos[i].error_radius_m, 1.0 + i);
    EXPECT_TRUE(aligned.photos[i].cam_from_enu.TargetOriginInSource().isApprox(
        Eigen::Vector3d(10.0 * i, 20.0, 50.0)));
  }
}

TEST(PlacementName, IsAStableWordForEachKind) {
  EXPECT_STREQ(PlacementName(Placement::kAligned), "aligned");
  EXPECT_STREQ(PlacementName(Placement::kPoseOnly), "pose_only");
}

}  // namespace
}  // namespace skyquilt::alignment
