// What a list's positions become on photos.
#include "core/poses/photo_rows.h"

#include <gtest/gtest.h>

#include <optional>

namespace skyquilt::poses {
namespace {

flight::RecordedPosition TakenFromList(const std::optional<Eigen::Vector3d>& sigma_in_ned_m, bool is_fixed) {
  flight::FlightLog list;
  list.file_name = "geo.txt";
  flight::CameraEvent& row = list.events.emplace_back();
  row.has_time = false;
  row.image_name = "a.jpg";
  row.position = geo::LatLon{46.84, -91.99};
  row.height_ellipsoid_m = 300.0;
  row.sigma_in_ned_m = sigma_in_ned_m;
  row.is_rtk_fixed = is_fixed;
  std::vector<flight::Photo> photos(1);
  photos[0].name = "a.jpg";
  ApplyPhotoRows({list}, photos);
  return photos[0].position.value_or(flight::RecordedPosition());
}

TEST(PhotoRows, ThatStateCentimetresAreOfCorrectedPositions) {
  const auto surveyed = TakenFromList(Eigen::Vector3d(0.02, 0.02, 0.04), false);
  EXPECT_TRUE(surveyed.is_rtk_fixed);
  EXPECT_DOUBLE_EQ(*surveyed.sigma_horizontal_m, 0.02);
  EXPECT_DOUBLE_EQ(*surveyed.sigma_vertical_m, 0.04);
  EXPECT_TRUE(TakenFromList(std::nullopt, true).is_rtk_fixed) << "the list says it in a word";
}

TEST(PhotoRows, ThatStateMoreOrNothingAreNot) {
  EXPECT_FALSE(TakenFromList(std::nullopt, false).is_rtk_fixed);
  EXPECT_FALSE(TakenFromList(Eigen::Vector3d(1.5, 1.5, 3.0), false).is_rtk_fixed);
  EXPECT_FALSE(TakenFromList(Eigen::Vector3d(0.05, 0.05, 3.0), false).is_rtk_fixed);
  EXPECT_FALSE(TakenFromList(Eigen::Vector3d(0.0, 0.0, 0.0), false).is_rtk_fixed) << "a program's default";
  EXPECT_FALSE(TakenFromList(Eigen::Vector3d(1e-9, 1e-9, 1e-300), false).is_rtk_fixed)
      << "nobody measured it";
}

}  // namespace
}  // namespace skyquilt::poses
