#include "core/pipeline/read_control.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace skyquilt::pipeline {
namespace {

flight::InputFile Write(const std::string& name, const std::string& text) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / ("read_control_" + name);
  std::ofstream(path) << text;
  return {name, path};
}

TEST(ReadControl, CountsPixelsFromTheMiddleOfTheFirstAndGathersSightingsOfAPoint) {
  const ReadControlResult result = ReadControl({Write("gcp_list.txt",
                                                      "EPSG:4326\n"
                                                      "7.1 46.8 500 100.5 200.5 A.JPG north\n"
                                                      "7.1 46.8 500 300.5 250.0 B.JPG north\n"
                                                      "7.2 46.9 510 30 40 B.JPG south\n")});
  EXPECT_TRUE(result.warnings.empty());
  ASSERT_EQ(result.points.size(), 2u);
  EXPECT_EQ(result.points[0].name, "north");
  EXPECT_NEAR(result.points[0].position.lat_deg, 46.8, 1e-9);
  ASSERT_EQ(result.points[0].sightings.size(), 2u);
  EXPECT_EQ(result.points[0].sightings[0].pixel_in_image, Eigen::Vector2d(100.0, 200.0));
  EXPECT_EQ(result.points[1].sightings[0].photo_name, "B.JPG");
}

TEST(ReadControl, LeavesPositionsOfPhotosAndNotesAlone) {
  const ReadControlResult result = ReadControl({Write("geo.txt", "EPSG:4326\nA.JPG 7.1 46.8 500\n"),
                                                Write("notes.txt", "windy\n"), Write("A.JPG", "no photo")});
  EXPECT_TRUE(result.points.empty());
  EXPECT_TRUE(result.warnings.empty());
}

}  // namespace
}  // namespace skyquilt::pipeline
