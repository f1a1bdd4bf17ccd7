#include "core/pipeline/report/odm_exports.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/flight/logs/formats.h"
#include "core/poses/conventions/attitude_convention.h"

namespace skyquilt::pipeline {
namespace {

alignment::AlignedFlight Flight() {
  alignment::AlignedFlight flight;
  flight.frame = geo::LocalFrame({46.8, 7.1, 500.0});
  alignment::AlignedPhoto photo;
  photo.photo.name = "A.JPG";
  photo.photo.camera_key = "one";
  photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  photo.intrinsics.center_x_px += 8.0;
  photo.intrinsics.k1 = -0.1;
  const Eigen::Quaterniond lean(Eigen::AngleAxisd(0.2, Eigen::Vector3d(0.6, 0.8, 0.0)));
  photo.cam_from_enu =
      geo::Rigid3::FromRotationAndTargetOrigin(poses::NadirCamFromEnu(2.1) * lean, {30.0, -40.0, 60.0});
  photo.error_radius_m = 1.5;
  flight.photos.push_back(photo);
  photo.photo.name = "B C.JPG";
  flight.photos.push_back(photo);
  return flight;
}

TEST(OdmExports, ReadBackAsThePosesTheyWereWrittenFrom) {
  const alignment::AlignedFlight flight = Flight();
  const std::string text = OdmGeoTxt(flight);
  EXPECT_TRUE(text.ends_with("in their names: 1 photo\n")) << text;
  const auto log = flight::ParseGeoTxt("geo.txt", flight::BytesOf(text));
  ASSERT_TRUE(log.ok());
  ASSERT_EQ(log->events.size(), 1u) << "a name with a blank cannot be held";
  const flight::CameraEvent& event = log->events.front();
  EXPECT_EQ(*event.image_name, "A.JPG");
  const Eigen::Vector3d center = flight.frame.EnuFromWgs84(
      {event.position->lat_deg, event.position->lon_deg, *event.height_ellipsoid_m});
  EXPECT_LT((center - flight.photos[0].cam_from_enu.TargetOriginInSource()).norm(), 0.01);
  const Eigen::Vector3d& angles = *event.yaw_pitch_roll_rad;
  const Eigen::Quaterniond back =
      poses::CamFromEnu({event.attitude_kind, angles.x(), angles.y(), angles.z(), "geo.txt"});
  EXPECT_LT(back.angularDistance(flight.photos[0].cam_from_enu.rotation), 1e-6);
}

TEST(OdmExports, SayNoAccuracyWhereNothingSupportsTheMapsPlace) {
  alignment::AlignedFlight flight = Flight();
  flight.photos[0].placement = alignment::Placement::kAligned;
  const auto says_accuracy = [](const std::string& text) {
    const auto log = flight::ParseGeoTxt("geo.txt", flight::BytesOf(text));
    return log.ok() && log->events.at(0).sigma_in_ned_m.has_value();
  };
  EXPECT_TRUE(says_accuracy(OdmGeoTxt(flight)));
  const std::string unsupported = OdmGeoTxt(flight, 0.0, alignment::ErrorsKnown::kOfPoseOnly);
  EXPECT_NE(unsupported.find("A.JPG"), std::string::npos);
  EXPECT_FALSE(says_accuracy(unsupported));
  flight.photos[0].placement = alignment::Placement::kPoseOnly;
  EXPECT_TRUE(says_accuracy(OdmGeoTxt(flight, 0.0, alignment::ErrorsKnown::kOfPoseOnly)));
  EXPECT_FALSE(says_accuracy(OdmGeoTxt(flight, 0.0, alignment::ErrorsKnown::kOfNone)));
}

TEST(OdmExports, CountHeightsAsTheSurveyDoesThatPlacesTheMap) {
  const auto height_m = [](const std::string& text) {
    const auto log = flight::ParseGeoTxt("geo.txt", flight::BytesOf(text));
    return log.ok() ? log->events.at(0).height_ellipsoid_m.value_or(0.0) : 0.0;
  };
  const std::string recorded = OdmGeoTxt(Flight()), surveyed = OdmGeoTxt(Flight(), -47.25);
  EXPECT_NEAR(height_m(surveyed), height_m(recorded) - 47.25, 0.001);
  EXPECT_NE(surveyed.find("surveyed points"), std::string::npos);
  EXPECT_EQ(recorded.find("surveyed points"), std::string::npos);
}

TEST(OdmExports, AreKnownFromAListThatSomebodyMade) {
  alignment::AlignedFlight flight = Flight();
  EXPECT_TRUE(IsOdmGeoTxt(OdmGeoTxt(flight)));
  EXPECT_TRUE(IsOdmGeoTxt(OdmGeoTxt(flight, -47.25, alignment::ErrorsKnown::kOfNone)));
  for (const char* others :
       {"", "mine", "EPSG:4326\n", "EPSG:4326\n# mine\n", "EPSG:4326\nA.JPG 7.1 46.8 560\n",
        "EPSG:4326\nA.JPG 7.1000000000 46.8000000000 560.0000\n",
        "EPSG:4326\nA.JPG 7.1000000000 46.8000000000 560.0000 1.000000 2.000000 3.000000 0.02 0.04\n"}) {
    EXPECT_FALSE(IsOdmGeoTxt(others)) << others;
  }
  flight.photos.erase(flight.photos.begin());
  EXPECT_TRUE(IsOdmGeoTxt(OdmGeoTxt(flight))) << "of photos that it cannot name";
}

TEST(OdmExports, TellTheLensInWidthsOfTheLongerSide) {
  const auto cameras = nlohmann::json::parse(OdmCamerasJson(Flight()));
  ASSERT_EQ(cameras.size(), 1u);
  const auto& lens = cameras.at("all");
  EXPECT_EQ(lens.at("projection_type"), "brown");
  EXPECT_DOUBLE_EQ(lens.at("focal_x"), 0.75);
  EXPECT_DOUBLE_EQ(lens.at("c_x"), 0.002);
  EXPECT_DOUBLE_EQ(lens.at("c_y"), 0.0);
  EXPECT_DOUBLE_EQ(lens.at("k1"), -0.1);
}

TEST(OdmExports, TellCamerasApartWhereThereAreSeveral) {
  alignment::AlignedFlight flight = Flight();
  flight.photos[0].photo.make = "DJI";
  flight.photos[1].photo.make = "Parrot";
  flight.photos[1].photo.camera_key = "two";
  EXPECT_EQ(nlohmann::json::parse(OdmCamerasJson(flight)).size(), 2u);
}

}  // namespace
}  // namespace skyquilt::pipeline
