#include "core/render/seams/seam_map.h"

#include <gtest/gtest.h>

#include "core/geo/web_mercator.h"
#include "tests/support/simulated_map.h"

namespace skyquilt::render {
namespace {

simulate::SimulateOptions SmallFlight() {
  simulate::SimulateOptions options;
  options.intrinsics = camera::Intrinsics::Centered(480, 360, 360.0);
  options.trajectory.photos = 12;
  options.vignetting = 0.2;
  options.exposure_jitter = 0.08;
  return options;
}

TEST(SeamMap, GivesEverySeenCellToAPhotoThatSeesIt) {
  const test::SimulatedMap map = test::MakeSimulatedMap(SmallFlight());
  const SeamMap seams = map.Seams({});
  int cells = 0;
  for (int row = 0; row < seams.grid.rows; ++row) {
    for (int column = 0; column < seams.grid.columns; ++column) {
      const std::int32_t photo = seams.labels.At(column, row);
      if (photo == kNoPhoto) {
        for (const PhotoLevels& levels : seams.levels) EXPECT_FALSE(levels.SeesWhole(column, row));
        continue;
      }
      ++cells;
      bool someone_sees_it_whole = false;
      for (const PhotoLevels& levels : seams.levels) someone_sees_it_whole |= levels.SeesWhole(column, row);
      EXPECT_EQ(seams.levels[static_cast<std::size_t>(photo)].SeesWhole(column, row), someone_sees_it_whole);
    }
  }
  EXPECT_GT(cells, 5000);
}

TEST(SeamMap, IsTheSameWithAnyNumberOfThreads) {
  const test::SimulatedMap map = test::MakeSimulatedMap(SmallFlight());
  const SeamMap one = map.Seams({.threads = 1}), three = map.Seams({.threads = 3});
  for (int row = 0; row < one.grid.rows; ++row) {
    for (int column = 0; column < one.grid.columns; ++column) {
      ASSERT_EQ(one.labels.At(column, row), three.labels.At(column, row));
    }
  }
  for (std::size_t i = 0; i < one.levels.size(); ++i)
    EXPECT_EQ(one.levels[i].eighths, three.levels[i].eighths);
}

TEST(SeamMap, GoesRoundCarsThatMove) {
  const test::SimulatedMap map = test::MakeSimulatedMap(SmallFlight(), {}, 60);
  const test::ObjectCount nearest = test::CountCars(map, map.Seams({.moves_seams = false}));
  const test::ObjectCount moved = test::CountCars(map, map.Seams({}));
  EXPECT_GE(nearest.twice + nearest.in_part, 3) << "the scene must be hard for this to say anything";
  EXPECT_LE(moved.BrokenShare(), 0.05) << moved.twice << " twice, " << moved.in_part << " in part";
}

TEST(SeamMap, ShowsCarsThatDroveOnNoMoreThanOnce) {
  simulate::SimulateOptions options = SmallFlight();
  options.trajectory.photos = 60;  // line beside line: most of the ground is seen again half a minute later
  const test::SimulatedMap map = test::MakeSimulatedMap(options, {}, 80);
  const test::ObjectCount cars = test::CountCars(map, map.Seams({}));
  EXPECT_LE(cars.BrokenShare(), 0.05) << cars.twice << " twice, " << cars.in_part << " in part";
}

TEST(SeamMap, GoesRoundBuildings) {
  simulate::SimulateOptions options = SmallFlight();
  options.world.has_boxes = true;
  options.world.seed = 2;
  options.trajectory.photos = 40;
  options.trajectory.height_m = 90.0;
  const test::SimulatedMap map = test::MakeSimulatedMap(options);
  const test::ObjectCount roofs = test::CountRoofs(map, map.Seams({}));
  ASSERT_GT(roofs.objects, 5);
  EXPECT_LE(roofs.BrokenShare(), 0.05) << roofs.twice << " twice, " << roofs.in_part << " in part";
}

// From so high up that its pixels cover ten times the ground: near the point below it, it stands most nearly
// above.
TEST(SeamMap, APhotoWithFarCoarserPixelsGivesWay) {
  test::SimulatedMap map = test::MakeSimulatedMap(SmallFlight());
  constexpr std::size_t kHigh = 5;
  alignment::AlignedPhoto& high = map.flight.photos[kHigh];
  Eigen::Vector3d center = high.cam_from_enu.TargetOriginInSource();
  center.z() *= 10.0;
  high.height_above_ground_m *= 10.0;
  high.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(high.cam_from_enu.rotation, center);
  map.plan = *PlanMosaic(map.flight, map.ground, {});
  const SeamMap seams = map.Seams({});
  int of_high = 0;
  for (int row = 0; row < seams.grid.rows; ++row) {
    for (int column = 0; column < seams.grid.columns; ++column) {
      if (seams.labels.At(column, row) != static_cast<std::int32_t>(kHigh)) continue;
      ++of_high;
      for (std::size_t i = 0; i < seams.levels.size(); ++i) {
        EXPECT_FALSE(i != kHigh && seams.levels[i].SeesWhole(column, row)) << i << " sees it better";
      }
    }
  }
  EXPECT_GT(of_high, 1000) << "what nobody else sees";
}

TEST(SeamMap, ShowsNothingBeyondTheLookAngle) {
  test::SimulatedMap map = test::MakeSimulatedMap(SmallFlight());
  const double max_look_rad = geo::DegToRad(20.0);
  for (alignment::AlignedPhoto& photo : map.flight.photos) photo.max_look_rad = max_look_rad;
  map.plan = *PlanMosaic(map.flight, map.ground, {});
  const SeamMap seams = map.Seams({});
  int cells = 0;
  for (int row = 0; row < seams.grid.rows; ++row) {
    for (int column = 0; column < seams.grid.columns; ++column) {
      const std::int32_t photo = seams.labels.At(column, row);
      if (photo == kNoPhoto) continue;
      ++cells;
      const Eigen::Vector3d ground =
          map.flight.frame.EnuAtHeight(geo::LatLonFromMerc(seams.grid.CellInMerc(column, row)), 0.0);
      const Eigen::Vector3d up =
          map.flight.photos[static_cast<std::size_t>(photo)].cam_from_enu.TargetOriginInSource() - ground;
      EXPECT_LE(std::atan2(up.head<2>().norm(), up.z()), max_look_rad + 1e-6);
    }
  }
  EXPECT_GT(cells, 1000);
}

TEST(SeamMap, CorrectionsOfNeighboursMeetAtTheSeam) {
  const test::SimulatedMap map = test::MakeSimulatedMap(SmallFlight());
  const SeamMap seams = map.Seams({});
  double corrections = 0.0;
  for (const PhotoLevels& levels : seams.levels) {
    for (const auto& eighths : levels.eighths)
      corrections = std::max(corrections, std::abs(eighths[0] / 8.0));
  }
  // Most of the light was evened out by the gains: what is left is small, and it is there.
  EXPECT_GT(corrections, 0.2);
  EXPECT_LT(corrections, 12.0);
}

}  // namespace
}  // namespace skyquilt::render
