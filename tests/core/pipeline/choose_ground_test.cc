// Whether a flight asks for heights: by what ties its photos, and by how many photos show its ground.
#include "core/pipeline/surface/choose_ground.h"

#include <gtest/gtest.h>

#include "tests/core/pipeline/displaced_flight.h"

namespace skyquilt::pipeline {
namespace {

// A flight over level ground; of a hundred places on it `raised` are so far above it.
alignment::AlignedFlight FlightOver(int raised, double above_m) {
  alignment::AlignedFlight flight = Displaced({}).known.flight;
  geo::Bounds2 area;
  for (const alignment::AlignedPhoto& photo : flight.photos)
    area.Include(Eigen::Vector2d(photo.cam_from_enu.TargetOriginInSource().head<2>()));
  for (int i = 0; i < 100; ++i) {
    const double u = 0.05 + 0.1 * (i % 10), v = 0.05 + 0.1 * (i / 10);
    flight.tie_points_in_enu.emplace_back(area.min.x() + u * area.Width(), area.min.y() + v * area.Height(),
                                          i * 37 % 100 < raised ? above_m : 0.05);
  }
  return flight;
}

GroundChoice ChoiceFor(const alignment::AlignedFlight& flight) {
  return ChooseGround(flight, ground::GroundSurface::Plane(0.0));
}

TEST(ChooseGround, HousesThatLeanStandUpright) {
  const GroundChoice choice = ChoiceFor(FlightOver(30, 6.0));
  EXPECT_GT(choice.leaning_share, 0.1);
  EXPECT_LE(choice.leaning_share, 0.3);
  EXPECT_GT(choice.seen_share, 0.5);
  EXPECT_TRUE(IsUpright(choice));
}

TEST(ChooseGround, AMeadowAndTwoMolehillsAreSmooth) {
  EXPECT_EQ(ChoiceFor(FlightOver(0, 0.0)).leaning_share, 0.0);
  EXPECT_FALSE(IsUpright(ChoiceFor(FlightOver(30, 0.06))));
  EXPECT_FALSE(IsUpright(ChoiceFor(FlightOver(2, 6.0))));
}

TEST(ChooseGround, WhatTwoPhotosShowIsSmooth) {
  alignment::AlignedFlight flight = FlightOver(30, 6.0);
  flight.photos.resize(2);
  const GroundChoice choice = ChoiceFor(flight);
  EXPECT_EQ(choice.seen_share, 0.0);
  EXPECT_FALSE(IsUpright(choice));
  flight.photos.clear();
  EXPECT_EQ(ChoiceFor(flight), GroundChoice());
}

TEST(ChooseGround, WithoutTiePointsNothingIsKnownToLean) {
  alignment::AlignedFlight flight = FlightOver(30, 6.0);
  flight.tie_points_in_enu.clear();
  EXPECT_FALSE(IsUpright(ChoiceFor(flight)));
}

}  // namespace
}  // namespace skyquilt::pipeline
