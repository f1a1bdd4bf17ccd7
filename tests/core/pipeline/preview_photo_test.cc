#include "core/pipeline/preview_photo.h"

#include <gtest/gtest.h>

#include "tests/support/map_truth.h"
#include "tests/support/memory_sink.h"
#include "tests/support/simulated_map.h"
#include "tests/support/value_of.h"

namespace skyquilt::pipeline {
namespace {

TEST(PreviewPhoto, LiesWhereTheMapWillLie) {
  simulate::SimulateOptions options;
  options.intrinsics = camera::Intrinsics::Centered(1600, 1200, 1200.0);
  options.trajectory.photos = 2;
  const test::SimulatedMap map = test::MakeSimulatedMap(options);
  test::MemorySink tiles;
  const auto preview = PreviewPhoto(map.flight, 1, *map.photos,
                                    {.longer_side_px = 600, .gsd_m = {}, .jpeg_quality = 85}, tiles);
  ASSERT_TRUE(preview.ok()) << preview.error().message;
  EXPECT_EQ(static_cast<std::int64_t>(tiles.tiles.size()), preview->tiles);
  EXPECT_LT(preview->tiles, 60);
  EXPECT_LT(preview->max_zoom, map.plan.base_zoom);
  const test::MapError error = test::MeasureMapError(tiles, map.truth.world, map.flight.frame);
  EXPECT_GT(error.patches, 5);
  EXPECT_LT(error.shift_rmse_px, 0.3);
}

TEST(PreviewPhoto, SaysWhenThePhotoShowsNoGround) {
  simulate::SimulateOptions options;
  options.intrinsics = camera::Intrinsics::Centered(320, 240, 240.0);
  options.trajectory.photos = 1;
  test::SimulatedMap map = test::MakeSimulatedMap(options);
  map.flight.photos[0].cam_from_enu.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(geo::kPi, Eigen::Vector3d::UnitX())) *
      map.flight.photos[0].cam_from_enu.rotation;
  map.flight.photos[0].cam_from_enu.translation = -map.flight.photos[0].cam_from_enu.translation;
  test::MemorySink tiles;
  EXPECT_EQ(test::ErrorOf(PreviewPhoto(map.flight, 0, *map.photos, {}, tiles)).code,
            ErrorCode::kUnprocessable);
  EXPECT_TRUE(tiles.tiles.empty());
}

}  // namespace
}  // namespace skyquilt::pipeline
