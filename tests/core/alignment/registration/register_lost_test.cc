#include <gtest/gtest.h>

#include "core/alignment/attempts/lost_photos.h"
#include "tests/core/alignment/registration/synthetic_scene.h"

namespace skyquilt::alignment {
namespace {

constexpr std::size_t kLost = 2;

// Five photos of one line over level ground; the third is lost, the others lie where they were taken.
struct LostPhoto {
  SyntheticScene scene = MakeScene({.columns = 5, .rows = 1, .relief_m = 0.0});
  ExtractedFlight extracted;
  Attempt attempt;
  PhotoSet tied;
  std::vector<Track> tracks;

  LostPhoto() {
    for (std::size_t i = 0; i < scene.features.size(); ++i) {
      extracted.readable.push_back(&scene.features[i]);
      View view;
      view.intrinsics = scene.lens;
      view.cam_from_enu = scene.cam_from_enu[i];
      view.height_above_ground_m = 50.0;
      attempt.matched.views.push_back(view);
      tied.Append(i != kLost);
    }
    extracted.records.resize(scene.features.size());
  }
  // Every so-many-th keypoint of a tied photo is a track, at its place on the ground.
  void AddTracks(std::size_t every) {
    for (std::size_t i = 0; i < scene.features.size(); ++i) {
      for (std::size_t k = 0; tied.Has(i) && k < scene.features[i].keypoints.size(); k += every) {
        const Keypoint& keypoint = scene.features[i].keypoints[k];
        Track track;
        track.observations.push_back({static_cast<int>(i), {keypoint.x_px, keypoint.y_px}, 1.0});
        if (MeetGround(attempt.matched.views[i], attempt.relief, track.observations[0].pixel_in_image,
                       &track.point_in_enu))
          tracks.push_back(track);
      }
    }
  }
  std::vector<FoundPose> Register() const { return RegisterLost(extracted, attempt, tied, tracks, 2); }
  double OffM(const FoundPose& one) const {
    return (one.cam_from_world.TargetOriginInSource() - scene.cam_from_enu[kLost].TargetOriginInSource())
        .norm();
  }
};

TEST(RegisterLost, FindsThePhotoByThePointsThatOthersSee) {
  LostPhoto of;
  of.AddTracks(1);
  const std::vector<FoundPose> found = of.Register();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].photo, static_cast<int>(kLost));
  EXPECT_LT(of.OffM(found[0]), 0.5);
  EXPECT_FALSE(found[0].links.empty());
}

TEST(RegisterLost, FindsItByTheGroundWhereHardlyAPointIsATrack) {
  LostPhoto of;
  of.AddTracks(400);
  const std::vector<FoundPose> found = of.Register();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LT(of.OffM(found[0]), 0.5);
}

TEST(RegisterLost, LeavesAPhotoOfAnotherPlaceLost) {
  LostPhoto of;
  of.AddTracks(1);
  const SyntheticScene elsewhere = MakeScene({.columns = 5, .rows = 1, .relief_m = 0.0, .seed = 77});
  of.extracted.readable[kLost] = &elsewhere.features[kLost];
  EXPECT_TRUE(of.Register().empty());
}

}  // namespace
}  // namespace skyquilt::alignment
