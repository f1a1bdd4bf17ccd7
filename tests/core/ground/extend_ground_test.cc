#include "core/ground/extend_ground.h"

#include <gtest/gtest.h>

namespace skyquilt::ground {
namespace {

geo::Bounds2 Box(double west, double south, double east, double north) {
  geo::Bounds2 bounds;
  bounds.Include(Eigen::Vector2d(west, south));
  bounds.Include(Eigen::Vector2d(east, north));
  return bounds;
}

GroundSurface Known() { return GroundSurface::Grid({0.0, 0.0}, 2.0, 3, 2, {1, 2, 3, 4, 5, 6}, 3.5); }

TEST(ExtendGround, KeepsTheKnownGroundAndContinuesWithTheNew) {
  const GroundSurface added = GroundSurface::Grid({-20.0, -20.0}, 40.0, 2, 2, {9, 9, 9, 9}, 9.0);
  const GroundSurface grown = ExtendGround(Known(), added, Box(-3.0, 0.5, 7.0, 1.0));
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
  EXPECT_EQ(ExtendGround(Known(), flat, Box(1.0, 0.5, 3.0, 1.0)).Columns(), 3);
  EXPECT_TRUE(ExtendGround(flat, Known(), Box(-50.0, -50.0, 50.0, 50.0)).IsPlane());
  // A plane beyond is no knowledge: the border goes on.
  EXPECT_NEAR(ExtendGround(Known(), flat, Box(-8.0, 0.0, 4.0, 2.0)).HeightAt({-8.0, 0.0}), 1.0, 1e-9);
}

}  // namespace
}  // namespace skyquilt::ground
