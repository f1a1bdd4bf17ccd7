#include "core/ground/membrane_grid.h"

#include <gtest/gtest.h>

#include <cmath>

namespace skyquilt::ground {
namespace {

double HeightAt(const MembraneGrid& grid, double east_m, double north_m) {
  return GroundSurface::Grid(grid.south_west_in_enu, grid.cell_m, grid.columns, grid.rows, grid.heights_m,
                             0.0)
      .HeightAt({east_m, north_m});
}

double Hills(double east_m, double north_m) {
  return 4.0 * std::sin(0.08 * east_m) * std::cos(0.07 * north_m);
}

std::vector<Eigen::Vector3d> PointsOnHills() {
  std::vector<Eigen::Vector3d> points;
  for (int east = 0; east <= 100; east += 2) {
    for (int north = 0; north <= 80; north += 2)
      points.emplace_back(east, north, 20.0 + Hills(1.0 * east, 1.0 * north));
  }
  return points;
}

TEST(FitMembrane, FollowsThePoints) {
  const MembraneGrid grid = FitMembrane(PointsOnHills(), 2.0, GroundSurface::Plane(20.0), 10.0, 0.1);
  double square = 0.0;
  int count = 0;
  for (double east = 3.0; east < 98.0; east += 5.0) {
    for (double north = 3.0; north < 78.0; north += 5.0) {
      const double error_m = HeightAt(grid, east, north) - 20.0 - Hills(east, north);
      square += error_m * error_m;
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(square / count), 0.15);
}

TEST(FitMembrane, ReachesBeyondThePointsByItsMargin) {
  const MembraneGrid grid = FitMembrane(PointsOnHills(), 2.0, GroundSurface::Plane(20.0), 50.0, 0.1);
  EXPECT_LE(grid.south_west_in_enu.x(), -50.0);
  EXPECT_LE(grid.south_west_in_enu.y(), -50.0);
  EXPECT_GE(grid.south_west_in_enu.x() + grid.cell_m * (grid.columns - 1), 150.0);
  EXPECT_GE(grid.south_west_in_enu.y() + grid.cell_m * (grid.rows - 1), 130.0);
  EXPECT_EQ(grid.heights_m.size(), static_cast<std::size_t>(grid.columns) * grid.rows);
}

TEST(FitMembrane, SettlesOnTheBroadShapeFarFromThePoints) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 30; ++i) points.emplace_back(i % 6, i / 6, 35.0);
  const MembraneGrid grid = FitMembrane(points, 1.0, GroundSurface::Plane(20.0), 200.0, 1.0);
  EXPECT_NEAR(HeightAt(grid, 2.5, 2.0), 35.0, 1.5);
  EXPECT_NEAR(HeightAt(grid, 190.0, 190.0), 20.0, 0.5);
}

TEST(FitMembrane, IsNotMovedByOneWildPointAmongOthersOfItsCell) {
  std::vector<Eigen::Vector3d> points;
  for (int east = 0; east < 20; ++east) {
    for (int north = 0; north < 20; ++north) {
      for (int k = 0; k < 5; ++k) points.emplace_back(east, north, 20.0);
    }
  }
  points.emplace_back(10.0, 10.0, 400.0);
  const MembraneGrid grid = FitMembrane(points, 1.0, GroundSurface::Plane(20.0), 5.0, 0.1);
  EXPECT_NEAR(HeightAt(grid, 10.0, 10.0), 20.0, 0.01);
}

TEST(FitMembrane, IsTheBroadShapeWithoutPoints) {
  const MembraneGrid grid = FitMembrane({}, 2.0, GroundSurface::Plane(7.0), 10.0, 0.1);
  ASSERT_FALSE(grid.heights_m.empty());
  for (const float height_m : grid.heights_m) EXPECT_FLOAT_EQ(height_m, 7.0F);
}

}  // namespace
}  // namespace skyquilt::ground
