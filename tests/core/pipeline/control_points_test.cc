#include "core/pipeline/control_points.h"

#include <gtest/gtest.h>

namespace skyquilt::pipeline {
namespace {

flight::GcpList Read(std::string_view text) {
  const auto list = flight::ParseGcpList("gcp_list.txt", flight::BytesOf(text));
  EXPECT_TRUE(list.ok());
  return *list;
}

TEST(ControlPoints, CountPixelsFromTheMiddleOfTheFirstAndGatherSightingsOfAPoint) {
  const auto points =
      ControlPointsOf({Read("EPSG:4326\n"
                            "7.1 46.8 500 100.5 200.5 A.JPG north\n"
                            "7.1 46.8 500 300.5 250.0 B.JPG north\n"
                            "7.2 46.9 510 30 40 B.JPG south\n")});
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].name, "north");
  EXPECT_NEAR(points[0].position.lat_deg, 46.8, 1e-9);
  ASSERT_EQ(points[0].sightings.size(), 2u);
  EXPECT_EQ(points[0].sightings[0].pixel_in_image, Eigen::Vector2d(100.0, 200.0));
  EXPECT_EQ(points[1].sightings[0].photo_name, "B.JPG");
}

TEST(ControlPoints, OfSeveralListsStandBesideEachOther) {
  const flight::GcpList list = Read("EPSG:4326\n7.1 46.8 500 100.5 200.5 A.JPG\n");
  const auto points = ControlPointsOf({list, list});
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1].sightings.size(), 1u);
}

TEST(ControlPoints, OfNoListAreNone) { EXPECT_TRUE(ControlPointsOf({}).empty()); }

}  // namespace
}  // namespace skyquilt::pipeline
