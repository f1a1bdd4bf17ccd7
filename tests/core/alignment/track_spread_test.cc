// Which tracks an adjustment takes of many.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace skyquilt::alignment
