#include "core/pipeline/placing/control_points.h"

#include <gtest/gtest.h>

#include <string>

namespace skyquilt::pipeline {
namespace {

flight::GcpList Read(std::string_view text) {
  const auto list = flight::ParseGcpList("gcp_list.txt", flight::BytesOf(text));
  EXPECT_TRUE(list.ok());
  return *list;
}

TEST(ControlPoints, HaveNoHeightsWhereAllAreZero) {
  const std::string rows =
      "EPSG:4326\n7.1 46.8 0 100 200 A.JPG a\n7.2 46.8 0.00 100 200 A.JPG b\n7.1 46.9 0.0 100 200 A.JPG c\n";
  const flight::GcpList list = Read(rows);
  ASSERT_EQ(list.warnings.size(), 1u);
  EXPECT_EQ(list.warnings[0].code, flight::RemarkCode::kHeightsNotSurveyed);
  for (const auto& point : ControlPointsOf({list})) EXPECT_FALSE(point.height_m) << point.name;
  const auto one_high = ControlPointsOf({Read(rows + "7.2 46.9 0.4 100 200 A.JPG d\n")});
  ASSERT_EQ(one_high.size(), 4u);
  EXPECT_EQ(one_high[0].height_m, 0.0);
  const auto few = ControlPointsOf({Read("EPSG:4326\n7.1 46.8 0 100 200 A.JPG a\n")});
  EXPECT_EQ(few[0].height_m, 0.0);
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

TEST(ControlPoints, ThatNoPhotoIsMarkedWithAreLeftOut) {
  const auto points = ControlPointsOf(
      {Read("EPSG:4326\n7.1 46.8 500 0 0 - a\n7.2 46.8 500 100.5 200.5 A.JPG b\n7.3 46.8 500 0 0 - c\n")});
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].name, "b");
}

TEST(ControlPoints, WhoseNamesEndInCheckPlaceNothing) {
  const std::vector<flight::GcpList> lists{
      Read("EPSG:4326\n7.1 46.8 500 100 200 A.JPG a\n7.2 46.8 500 100 200 A.JPG b_Check\n"
           "7.3 46.8 500 100 200 A.JPG c check\n7.4 46.8 500 100 200 A.JPG checkerboard\n")};
  ASSERT_EQ(ControlPointsOf(lists).size(), 2u);
  EXPECT_EQ(ControlPointsOf(lists)[1].name, "checkerboard");
  ASSERT_EQ(CheckPointsOf(lists).size(), 2u);
  EXPECT_EQ(CheckPointsOf(lists)[0].name, "b_Check");
  EXPECT_EQ(CheckPointsOf(lists)[1].name, "c_check");
}

TEST(ControlPoints, MayBeNamedCheckPointsByAColumn) {
  const std::vector<flight::GcpList> lists{
      Read("EPSG:4326\nlon,lat,z,px,py,image,name,check\n7.1,46.8,500,100,200,A.JPG,a,yes\n"
           "7.2,46.8,500,100,200,A.JPG,b,0\n7.3,46.8,500,100,200,A.JPG,c,\n")};
  EXPECT_EQ(ControlPointsOf(lists).size(), 2u);
  ASSERT_EQ(CheckPointsOf(lists).size(), 1u);
  EXPECT_EQ(CheckPointsOf(lists)[0].name, "a_check");
}

TEST(ControlPoints, OfNoListAreNone) { EXPECT_TRUE(ControlPointsOf({}).empty()); }

}  // namespace
}  // namespace skyquilt::pipeline
