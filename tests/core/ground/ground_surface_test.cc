// What a wall hides: from where, how far behind it, and that nothing hides itself.
#include "core/ground/ground_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "core/ground/extend_ground.h"

namespace skyquilt::ground {
namespace {

constexpr double kCellM = 0.1;
constexpr int kSide = 200;  // 20 m

// Level ground about a flat roof from 8 to 12 m east, 4 m high, as long as the ground.
GroundSurface LongHouse() {
  std::vector<float> heights(static_cast<std::size_t>(kSide) * kSide, 0.0f);
  for (int row = 0; row < kSide; ++row) {
    for (int column = 80; column < 120; ++column)
      heights[static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(column)] = 4.0f;
  }
  return GroundSurface::WithSteps({0.0, 0.0}, kCellM, kSide, kSide, std::move(heights), 0.0);
}

TEST(IsOccluded, IsTheGroundBehindAWallAsFarAsTheSightOverItReaches) {
  const GroundSurface house = LongHouse();
  // From 40 m above a point 10 m west of the roof's far edge the sight over it comes down 1.1 m behind.
  const Eigen::Vector3d camera(2.0, 10.0, 40.0);
  EXPECT_TRUE(IsOccluded(house, {12.4, 10.0, 0.0}, camera));
  EXPECT_TRUE(IsOccluded(house, {12.8, 10.0, 0.0}, camera));
  EXPECT_FALSE(IsOccluded(house, {13.3, 10.0, 0.0}, camera));
  EXPECT_FALSE(IsOccluded(house, {7.7, 10.0, 0.0}, camera)) << "before the house";
  EXPECT_FALSE(IsOccluded(house, {12.4, 10.0, 0.0}, {12.4, 10.0, 40.0})) << "from right above";
  EXPECT_FALSE(IsOccluded(house, {12.4, 10.0, 0.0}, {18.0, 10.0, 40.0})) << "from the other side";
  EXPECT_TRUE(IsOccluded(house, {12.4, 10.0, 0.0}, {5.0, 3.0, 40.0})) << "aslant";
}

TEST(IsOccluded, IsNoRoofOfItself) {
  const GroundSurface house = LongHouse();
  for (double east = 8.0; east < 12.0; east += 0.1) {
    for (const double from : {-30.0, 2.0, 10.0, 50.0})
      EXPECT_FALSE(IsOccluded(house, {east, 10.0, 4.0}, {from, 10.0, 44.0})) << east << " from " << from;
  }
}

TEST(IsOccluded, IsNothingWhereTheGroundHasNoSteps) {
  const GroundSurface smooth =
      GroundSurface::Grid({0.0, 0.0}, 10.0, 2, 2, std::vector<float>{0.0f, 0.0f, 9.0f, 9.0f}, 4.0);
  EXPECT_FALSE(IsOccluded(smooth, {5.0, 1.0, 0.0}, {5.0, 40.0, 20.0}));
}

// The squares that are passed over at once change nothing.
TEST(IsOccluded, IsAsAWalkOfEveryCellHasIt) {
  std::mt19937 random(3);
  std::vector<float> heights(static_cast<std::size_t>(kSide) * kSide, 0.0f);
  std::uniform_int_distribution<int> cell(0, kSide - 1), tall(1, 6);
  for (int tower = 0; tower < 40; ++tower) {
    const int left = cell(random), low = cell(random);
    const auto height = static_cast<float>(tall(random));
    for (int row = low; row < std::min(kSide, low + 6); ++row) {
      for (int column = left; column < std::min(kSide, left + 6); ++column)
        heights[static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(column)] = height;
    }
  }
  const GroundSurface towers = GroundSurface::WithSteps({0.0, 0.0}, kCellM, kSide, kSide, heights, 0.0);
  // The same heights in one square of its own each are walked cell by cell.
  std::uniform_real_distribution<double> at(0.0, 19.9);
  int hidden = 0, other = 0;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector2d foot(at(random), at(random));
    const Eigen::Vector3d point(foot.x(), foot.y(), towers.HeightAt(foot)), eye(at(random), at(random), 25.0);
    const double away = (eye.head<2>() - foot).norm();
    bool is_hidden = false;
    for (double t = 2.0 * kCellM; t < away; t += kCellM) {
      const Eigen::Vector2d on = foot + (eye.head<2>() - foot) * (t / away);
      const int column = static_cast<int>(std::lround(on.x() / kCellM)),
                row = static_cast<int>(std::lround(on.y() / kCellM));
      if (column < 0 || row < 0 || column >= kSide || row >= kSide) break;
      is_hidden |= heights[static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(column)] >
                   point.z() + kCellM + (eye.z() - point.z()) * t / away;
    }
    hidden += is_hidden ? 1 : 0;
    other += is_hidden != IsOccluded(towers, point, eye) ? 1 : 0;
  }
  EXPECT_GT(hidden, 50);
  EXPECT_LE(other, 2) << "but where a line touches a corner";
}

geo::Bounds2 Box(double west, double south, double east, double north) {
  geo::Bounds2 bounds;
  bounds.Include(Eigen::Vector2d(west, south));
  bounds.Include(Eigen::Vector2d(east, north));
  return bounds;
}

std::vector<Eigen::Vector2d> Outline(double west, double south, double east, double north) {
  return {{west, south}, {east, south}, {east, north}, {west, north}};
}

GroundSurface Known() { return GroundSurface::Grid({0.0, 0.0}, 2.0, 3, 2, {1, 2, 3, 4, 5, 6}, 3.5); }

TEST(ExtendGround, KeepsTheKnownGroundAndContinuesWithTheNew) {
  const GroundSurface added = GroundSurface::Grid({-20.0, -20.0}, 40.0, 2, 2, {9, 9, 9, 9}, 9.0);
  const GroundSurface grown =
      *ExtendGround(Known(), added, Box(-3.0, 0.5, 7.0, 1.0), {Outline(-1.0, -1.0, 5.0, 3.0)});
  for (double east = 0.0; east <= 4.0; east += 0.25) {
    for (double north = 0.0; north <= 2.0; north += 0.25) {
      EXPECT_NEAR(grown.HeightAt({east, north}), Known().HeightAt({east, north}), 1e-9);
    }
  }
  EXPECT_EQ(grown.HeightAt({-3.0, 1.0}), 9.0);
  EXPECT_EQ(grown.HeightAt({6.5, 1.0}), 9.0);
  EXPECT_EQ(grown.MeanHeight(), 3.5);
}

TEST(ExtendGround, ChangesNothingWhereNothingIsNeeded) {
  const GroundSurface flat = GroundSurface::Plane(7.0);
  EXPECT_EQ(ExtendGround(Known(), flat, Box(1.0, 0.5, 3.0, 1.0), {})->Columns(), 3);
  EXPECT_TRUE(ExtendGround(flat, Known(), Box(-50.0, -50.0, 50.0, 50.0), {Outline(-60.0, -60.0, 60.0, 60.0)})
                  ->IsPlane());
  // A plane beyond is no knowledge: the border goes on.
  EXPECT_NEAR(ExtendGround(Known(), flat, Box(-8.0, 0.0, 4.0, 2.0), {})->HeightAt({-8.0, 0.0}), 1.0, 1e-9);
}

// The corner of a grid around an L, or beside a field that lies aslant, is nothing but a guess.
TEST(ExtendGround, IsOfTheAddedPhotosWhereNoFinishedOneShowsIt) {
  const GroundSurface added = GroundSurface::Grid({-20.0, -20.0}, 40.0, 2, 2, {9, 9, 9, 9}, 9.0);
  const GroundSurface grown =
      *ExtendGround(Known(), added, Box(0.0, 0.0, 4.0, 2.0), {Outline(-1.0, -1.0, 0.5, 3.0)});
  EXPECT_EQ(grown.Columns(), 3);
  EXPECT_EQ(grown.HeightAt({0.0, 0.0}), 1.0);
  EXPECT_EQ(grown.HeightAt({0.5, 0.0}), 1.25);
  EXPECT_EQ(grown.HeightAt({4.0, 0.0}), 9.0);
  EXPECT_EQ(grown.HeightAt({4.0, 2.0}), 9.0);
}

TEST(ExtendGround, RisesBesideAPlane) {
  const GroundSurface added = GroundSurface::Grid({0.0, 0.0}, 4.0, 2, 2, {9, 9, 9, 9}, 9.0);
  const GroundSurface grown = *ExtendGround(GroundSurface::Plane(7.0), added, Box(0.0, 0.0, 8.0, 8.0),
                                            {Outline(-50.0, -50.0, 1.0, 50.0)});
  for (const double north : {0.0, 4.0, 8.0}) {
    EXPECT_EQ(grown.HeightAt({8.0, north}), 9.0);
    EXPECT_EQ(grown.HeightAt({1.0, north}), 7.0);
  }
  for (const double far : {-100.0, 100.0}) EXPECT_EQ(grown.HeightAt({far, 4.0}), 7.0);
  EXPECT_EQ(grown.MeanHeight(), 7.0);
}

TEST(ExtendGround, LeavesToAModelOfTheWholeWhatLiesFarFromIt) {
  const GroundSurface flat = GroundSurface::Plane(7.0);
  EXPECT_FALSE(ExtendGround(Known(), flat, Box(30'000.0, 30'000.0, 30'050.0, 30'050.0), {}));
  EXPECT_TRUE(ExtendGround(Known(), flat, Box(30'000.0, 0.0, 30'050.0, 50.0), {}))
      << "few cells along one line";
}

}  // namespace
}  // namespace skyquilt::ground
