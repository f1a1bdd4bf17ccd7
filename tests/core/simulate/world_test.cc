#include "core/simulate/world/world.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/simulate/world/random.h"
#include "tests/support/value_of.h"

namespace skyquilt::simulate {
namespace {

TEST(World, IsAFunctionOfSeedAndPlace) {
  WorldOptions options;
  const World a(options);
  const World b(options);
  options.seed = 2;
  const World other(options);
  RandomStream random(1, 2);
  int differing = 0;
  for (int i = 0; i < 500; ++i) {
    const double east = random.Uniform(-3000.0, 3000.0);
    const double north = random.Uniform(-3000.0, 3000.0);
    EXPECT_EQ(a.ColorAt(east, north, 0.02f), b.ColorAt(east, north, 0.02f));
    differing += a.ColorAt(east, north, 0.02f) != other.ColorAt(east, north, 0.02f) ? 1 : 0;
  }
  EXPECT_GT(differing, 450);
}

// The colour for a wide footprint must be close to the mean of the fine colours inside it: no aliasing.
TEST(World, WideFootprintsSeeTheMeanOfWhatTheyCover) {
  const World world(WorldOptions{});
  RandomStream random(3, 2);
  double squared = 0.0;
  double bias = 0.0;
  constexpr int kPlaces = 150;
  for (int i = 0; i < kPlaces; ++i) {
    const double east = random.Uniform(-500.0, 500.0);
    const double north = random.Uniform(-500.0, 500.0);
    constexpr double kWide = 0.5;
    constexpr int kSide = 25;
    double mean = 0.0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        mean += world
                    .ColorAt(east + kWide * ((x + 0.5) / kSide - 0.5),
                             north + kWide * ((y + 0.5) / kSide - 0.5), static_cast<float>(kWide / kSide))
                    .y() /
                (kSide * kSide);
      }
    }
    const double error = world.ColorAt(east, north, kWide).y() - mean;
    squared += error * error / kPlaces;
    bias += error / kPlaces;
  }
  EXPECT_LT(std::sqrt(squared), 9.0);
  EXPECT_LT(std::abs(bias), 2.0);
}

double FineContrast(TextureLevel texture, float footprint_m) {
  WorldOptions options;
  options.texture = texture;
  const World world(options);
  RandomStream random(5, 2);
  double squared = 0.0;
  constexpr int kPlaces = 4000;
  for (int i = 0; i < kPlaces; ++i) {
    const double east = random.Uniform(-500.0, 500.0);
    const double north = random.Uniform(-500.0, 500.0);
    const double step =
        world.ColorAt(east + 0.05, north, footprint_m).y() - world.ColorAt(east, north, footprint_m).y();
    squared += step * step / kPlaces;
  }
  return std::sqrt(squared);
}

TEST(World, RichGroundHasContrastAtFiveCentimetresAndBareGroundHardlyAny) {
  EXPECT_GT(FineContrast(TextureLevel::kRich, 0.015f), 8.0);
  EXPECT_LT(FineContrast(TextureLevel::kBare, 0.015f), 3.0);
}

TEST(World, RaysEndOnTheHills) {
  WorldOptions options;
  options.relief_m = 15.0;
  const World world(options);
  EXPECT_NEAR(world.TerrainHeightAt(0.0, 0.0), 0.0, 1e-12);
  RandomStream random(11, 2);
  double lowest = 0.0;
  double highest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d start{random.Uniform(-800.0, 800.0), random.Uniform(-800.0, 800.0), 80.0};
    const Eigen::Vector3d way =
        Eigen::Vector3d{random.Uniform(-2.5, 2.5), random.Uniform(-2.5, 2.5), -1.0}.normalized();
    const auto hit = test::ValueOf(world.CastRay(start, way, 5000.0));
    EXPECT_LT((start + hit.distance_m * way - hit.point_in_enu).norm(), 1e-9);
    EXPECT_NEAR(hit.point_in_enu.z(), world.TerrainHeightAt(hit.point_in_enu.x(), hit.point_in_enu.y()),
                2e-4);
    // Nothing was passed through on the way.
    for (double share = 0.02; share < 0.99; share += 0.02) {
      const Eigen::Vector3d before = start + share * hit.distance_m * way;
      EXPECT_GT(before.z(), world.TerrainHeightAt(before.x(), before.y()) - 1e-6);
    }
    lowest = std::min(lowest, hit.point_in_enu.z());
    highest = std::max(highest, hit.point_in_enu.z());
  }
  EXPECT_GT(highest - lowest, 12.0);
}

TEST(World, BuildingsStandInTheWayOfRays) {
  WorldOptions options;
  options.has_boxes = true;
  const World world(options);
  int roofs = 0;
  int walls = 0;
  for (double east = -400.0; east < 400.0; east += 3.0) {
    for (double north = -400.0; north < 400.0; north += 3.0) {
      const double height_m = world.SurfaceHeightAt(east, north);
      const auto down = test::ValueOf(world.CastRay({east, north, 50.0}, {0.0, 0.0, -1.0}, 200.0));
      EXPECT_NEAR(down.point_in_enu.z(), height_m, 1e-9);
      roofs += height_m > 1.0 ? 1 : 0;
      const Eigen::Vector3d way = Eigen::Vector3d(0.6, 0.3, -1.0).normalized();
      const auto aslant = test::ValueOf(world.CastRay({east, north, 50.0}, way, 200.0));
      walls += aslant.surface == SurfaceKind::kWall ? 1 : 0;
    }
  }
  EXPECT_GT(roofs, 100);
  EXPECT_GT(walls, 20);
}

TEST(World, RaysToTheSkyMeetNothing) {
  const World world(WorldOptions{});
  EXPECT_FALSE(world.CastRay({0.0, 0.0, 50.0}, {1.0, 0.0, 0.0}, 1e6).has_value());
  EXPECT_FALSE(world.CastRay({0.0, 0.0, 50.0}, {0.0, 0.0, 1.0}, 1e6).has_value());
}

TEST(World, SaysWhichGroundIsWater) {
  const World world({.seed = 3});
  int in_ponds = 0;
  for (double east = -300.0; east < 300.0; east += 5.0) {
    for (double north = -300.0; north < 300.0; north += 5.0) {
      const bool is_amid = world.IsWaterAt(east, north) && world.IsWaterAt(east - 3.0, north) &&
                           world.IsWaterAt(east + 3.0, north) && world.IsWaterAt(east, north - 3.0) &&
                           world.IsWaterAt(east, north + 3.0);
      if (!is_amid) continue;
      ++in_ponds;
      const Eigen::Vector3f color = world.ColorAt(east, north, 0.05f);
      EXPECT_LT(color.x() + 10.0f, color.z()) << east << " " << north;  // bluer than any land
    }
  }
  EXPECT_GT(in_ponds, 20);
}

}  // namespace
}  // namespace skyquilt::simulate
