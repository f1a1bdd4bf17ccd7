// The paper's method with its mathematics right: with exact poses the map is the world, to a fraction of a
// pixel.
#include <gtest/gtest.h>

#include "core/flight/photos/photo_decoder.h"
#include "core/flight/read_flight.h"
#include "core/pipeline/build_mosaic.h"
#include "core/simulate/simulate_flight.h"
#include "tests/support/map_truth.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::pipeline {
namespace {

struct Case {
  const char* name;
  double lat_deg, lon_deg, height_m, tilt_deg;
  bool is_distorted;
  double readout_s = 0.0;
};

class ExactPoses : public testing::TestWithParam<Case> {};

MosaicOptions PoseOnly(int threads, double readout_s) {
  MosaicOptions options;
  options.method = AlignMethod::kImu;
  options.threads = threads;
  options.readout_s = readout_s;
  return options;
}

TEST_P(ExactPoses, MapAgreesWithTheWorldToAPixel) {
  const Case& c = GetParam();
  simulate::SimulateOptions simulated;
  simulated.origin = {c.lat_deg, c.lon_deg};
  simulated.trajectory.photos = 6;
  simulated.trajectory.height_m = c.height_m;
  simulated.trajectory.max_tilt_rad = geo::DegToRad(c.tilt_deg);
  simulated.trajectory.yaw_rule = simulate::YawRule::kAnywhere;
  simulated.intrinsics = camera::Intrinsics::Centered(800, 600, 620.0);
  if (c.is_distorted) {
    simulated.intrinsics.k1 = -0.12, simulated.intrinsics.k2 = 0.05;
    simulated.intrinsics.p1 = 6e-4, simulated.intrinsics.p2 = -4e-4;
  }
  simulated.readout_s = c.readout_s;
  simulated.write_world = false;
  simulated.noise_counts = 0.0;
  const test::TemporaryFolder folder;
  SilentProgress progress;
  const auto flight = test::ValueOf(simulate::SimulateFlight(simulated, folder.path(), progress));
  const auto files = test::ValueOf(flight::ListInputFiles({folder / "photos"}));

  test::MemorySink map;
  const flight::FilePhotoSource photos;
  const auto built = test::ValueOf(BuildMosaic(files, PoseOnly(2, c.readout_s), photos, map, progress));
  EXPECT_EQ(built.report.photos_pose_only, 6);
  EXPECT_EQ(built.report.photos_left_out, 0);

  const test::MapError error = test::MeasureMapError(map, flight.world, flight.frame);
  EXPECT_GT(error.patches, 50);
  EXPECT_LT(error.shift_rmse_px, 0.5) << "mean " << error.mean_east_px << " " << error.mean_south_px;
  EXPECT_LT(std::abs(error.mean_east_px), 0.1);
  EXPECT_LT(std::abs(error.mean_south_px), 0.1);

  // Every camera stands over the map.
  const auto& bounds = built.report.bounds;
  for (const auto& photo : built.flight.photos) {
    // East of the date line the bounds go on beyond 180 degrees.
    const double lon_deg =
        bounds.west_deg + std::remainder(photo.photo.position->position.lon_deg - bounds.west_deg, 360.0);
    EXPECT_GE(lon_deg, bounds.west_deg);
    EXPECT_GE(photo.photo.position->position.lat_deg, bounds.south_deg);
    EXPECT_LE(lon_deg, bounds.east_deg);
    EXPECT_LE(photo.photo.position->position.lat_deg, bounds.north_deg);
  }

  // The same bytes in the same order from one thread.
  test::MemorySink again;
  ASSERT_TRUE(BuildMosaic(files, PoseOnly(1, c.readout_s), photos, again, progress).ok());
  EXPECT_EQ(map.order, again.order);
  EXPECT_TRUE(map.tiles == again.tiles);
}

INSTANTIATE_TEST_SUITE_P(Everywhere, ExactPoses,
                         testing::Values(Case{"south", -60.0, 12.0, 20.0, 15.0, false},
                                         Case{"equator", 0.0, -0.0001, 60.0, 15.0, true},
                                         Case{"alps", 46.0, 7.0, 120.0, 10.0, false},
                                         Case{"north", 68.0, 179.9999, 60.0, 15.0, true},
                                         Case{"rolling", 46.0, 7.0, 60.0, 10.0, true, 0.06}),
                         [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace skyquilt::pipeline
