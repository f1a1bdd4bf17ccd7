// Which tracks an adjustment takes of many, and which observations of one agree.
#include <gmock/gmock.h>

#include <vector>

#include "core/alignment/scene/tracks.h"

namespace skyquilt::alignment {
namespace {

using ::testing::ElementsAre;

const camera::Intrinsics kLens = camera::Intrinsics::Centered(100, 100, 100.0);

// Four cells; the one at the left top is crowded.
TEST(TrackSpread, EveryCellHasOneBeforeAnyHasTwo) {
  TrackSpread spread(1, 3, 2);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(10, 10), {11, 10}, {12, 10}, {90, 10}, {90, 90}}) {
    spread.BeginTrack();
    spread.SeenBy(0, pixel, kLens);
  }
  EXPECT_THAT(spread.Choose(), ElementsAre(0, 3, 4));
}

TEST(TrackSpread, ATrackIsTakenForAnyPhotoThatWantsIt) {
  TrackSpread spread(2, 1, 1);
  spread.BeginTrack();
  spread.SeenBy(0, {10, 10}, kLens);
  spread.BeginTrack();
  spread.SeenBy(0, {20, 20}, kLens);
  spread.SeenBy(1, {20, 20}, kLens);
  spread.BeginTrack();
  spread.SeenBy(1, {30, 30}, kLens);
  EXPECT_THAT(spread.Choose(), ElementsAre(0, 1)) << "the second photo wants one, and has it then";
}

TEST(TrackSpread, WhatNoPhotoWithASayShowsIsNotTaken) {
  TrackSpread spread(1, 3, 2);
  spread.BeginTrack();
  EXPECT_TRUE(spread.Choose().empty());
}

TEST(TrackSpread, PixelsBeyondThePictureCountToItsRim) {
  TrackSpread spread(1, 3, 2);
  spread.BeginTrack();
  spread.SeenBy(0, {-0.4, 130.0}, kLens);
  EXPECT_THAT(spread.Choose(), ElementsAre(0));
}

// As of a flight that hovers over a shadow that moves: of what a thousand photos see half goes, one by one.
TEST(TriangulateAgreed, KeepsWhatHalfOfAThousandPhotosAgreeOn) {
  constexpr int kPhotos = 1000;
  const camera::Intrinsics lens = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  std::vector<View> views;
  Track track;
  for (int photo = 0; photo < kPhotos; ++photo) {
    View& view = views.emplace_back();
    view.intrinsics = lens;
    view.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond::Identity(),
                                                                 {0.012 * photo - 6.0, 0.0, 0.0});
    const double way = photo % 4 == 1 ? 1.0 : -1.0;
    const double beside_px = photo % 2 == 1 ? way * (8.0 + 0.02 * photo) : 0.0;
    const Eigen::Vector2d seen = lens.ProjectBeyondFold(view.cam_from_enu * Eigen::Vector3d(0.0, 0.0, 50.0));
    track.observations.push_back({photo, seen + Eigen::Vector2d(0.0, beside_px), 1.0});
  }
  ASSERT_TRUE(TriangulateAgreed(views, 3.0, track));
  EXPECT_EQ(track.observations.size(), 500U);
  EXPECT_NEAR(track.point_in_enu.z(), 50.0, 0.1);
  EXPECT_NEAR(track.angle_rad, WidestAngle(views, track), 1e-12);
  Track from_one_place;
  from_one_place.observations.assign(3, track.observations.front());
  EXPECT_FALSE(TriangulateAgreed(views, 3.0, from_one_place)) << "nothing says how far it is";
}

}  // namespace
}  // namespace skyquilt::alignment
