#include "core/render/blocks/measure_seams.h"

#include <gtest/gtest.h>

#include "tests/support/simulated_map.h"

namespace skyquilt::render {
namespace {

test::SimulatedMap SharpMap() {
  simulate::SimulateOptions options;
  options.intrinsics = camera::Intrinsics::Centered(1600, 1200, 1200.0);
  options.trajectory.photos = 4;
  options.trajectory.photos_per_line = 2;
  return test::MakeSimulatedMap(options);
}

SeamShift Measure(const test::SimulatedMap& map, int threads = 2) {
  SilentProgress progress;
  MeasureSeamsOptions options;
  options.threads = threads;
  PhotoCache cache(*map.photos, std::int64_t{1} << 28);
  return SeamPatches(map.flight, map.ground, options).Measure(cache, progress);
}

TEST(MeasureSeams, FindsNothingToShiftBetweenPhotosThatLieRight) {
  const SeamShift shift = Measure(SharpMap());
  EXPECT_GT(shift.patches, 3);
  EXPECT_GT(2 * shift.reliable, shift.patches);
  EXPECT_LT(shift.p90_m, 0.5 * shift.gsd_m);
}

TEST(MeasureSeams, MeasuresByHowMuchAPhotoLiesOffOnAnyNumberOfThreads) {
  test::SimulatedMap map = SharpMap();
  // Every second photo lies 0.5 m off to the east.
  for (std::size_t i = 0; i < map.flight.photos.size(); i += 2) {
    geo::Rigid3& pose = map.flight.photos[i].cam_from_enu;
    pose = geo::Rigid3::FromRotationAndTargetOrigin(
        pose.rotation, pose.TargetOriginInSource() + Eigen::Vector3d(0.5, 0.0, 0.0));
  }
  const SeamShift one = Measure(map, 1);
  const SeamShift two = Measure(map, 2);
  EXPECT_NEAR(one.p90_m, 0.5, 0.5 * one.gsd_m);
  EXPECT_EQ(one.p90_m, two.p90_m);
  EXPECT_EQ(one.median_m, two.median_m);
}

TEST(MeasureSeams, SaysThatItSawNothingOfASinglePhoto) {
  test::SimulatedMap map = SharpMap();
  map.flight.photos.resize(1);
  const SeamShift shift = Measure(map);
  EXPECT_EQ(shift.patches, 0);
  EXPECT_EQ(shift.p90_m, 0.0);
}

}  // namespace
}  // namespace skyquilt::render
