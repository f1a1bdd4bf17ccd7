// How far a map may lean about the one line of its positions, in what is stated of it.
#include "core/pipeline/report/open_lean.h"

#include <gtest/gtest.h>

#include <string>

#include "core/flight/remarks/remark_words.h"
#include "core/pipeline/report/judge_map.h"

namespace skyquilt::pipeline {
namespace {

constexpr int kPhotos = 12;

// Photos from 60 m, every other one `apart_m` beside the first line, aligned where they were recorded.
struct LineFlight {
  alignment::AlignedFlight flight;
  poses::PoseReport poses;
  alignment::AlignReport report;

  LineFlight(double apart_m, bool has_gimbal, bool is_corrected) {
    flight.frame = geo::LocalFrame({46.8, 7.1, 500.0});
    for (int i = 0; i < kPhotos; ++i) {
      const Eigen::Vector3d center(i % 2 == 0 ? 0.0 : apart_m, 15.0 * i, 60.0);
      alignment::AlignedPhoto& photo = flight.photos.emplace_back();
      photo.photo.name = "p" + std::to_string(i);
      photo.placement = alignment::Placement::kAligned;
      photo.height_above_ground_m = 60.0;
      photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond::Identity(), center);
      const geo::Wgs84 at = flight.frame.Wgs84FromEnu(center);
      photo.photo.position.emplace().position = {at.lat_deg, at.lon_deg};
      photo.photo.position->is_rtk_fixed = is_corrected;
      if (has_gimbal) photo.photo.attitude.emplace();
    }
  }
  JudgedMap Map() const {
    return {.flight = flight, .poses = poses, .alignment = &report, .gsd_m = 0.02, .photo_gsd_m = 0.02};
  }
  JudgedMap Forecast() const { return {.flight = flight, .poses = poses, .is_forecast = true}; }
};

TEST(OpenLean, IsMostOfTheErrorOfOneLineByCorrectedPositions) {
  const LineFlight line(0.0, true, true);
  EXPECT_EQ(JudgeMap(line.Map()).absolute, (AbsoluteAccuracy{1.1, AbsoluteSupport::kRtk, kPhotos}));
  EXPECT_EQ(JudgeMap(line.Forecast()).absolute, JudgeMap(line.Map()).absolute);
  const std::vector<flight::Remark> remarks = RemarksOnPositions(line.Map());
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_EQ(
      flight::InWords(remarks[0]),
      "The 12 positions lie on one line, or at one spot: how far the cameras leaned about it is known to "
      "1 deg, 1.1 m on the ground. A second line beside it, or surveyed points, would tell more.");
}

TEST(OpenLean, IsHeldByASecondLine) {
  const LineFlight lines(30.0, true, true);
  EXPECT_EQ(JudgeMap(lines.Map()).absolute, (AbsoluteAccuracy{0.03, AbsoluteSupport::kRtk, kPhotos}));
  EXPECT_TRUE(RemarksOnPositions(lines.Map()).empty());
}

TEST(OpenLean, IsLessThanAReceiversErrorWithAGimbalAndMoreWithoutAngles) {
  const LineFlight gimbal(0.0, true, false), no_angles(0.0, false, false);
  EXPECT_EQ(JudgeMap(gimbal.Map()).absolute, (AbsoluteAccuracy{2.5, AbsoluteSupport::kGnss, kPhotos}));
  EXPECT_TRUE(RemarksOnPositions(gimbal.Map()).empty());
  EXPECT_EQ(JudgeMap(no_angles.Map()).absolute, (AbsoluteAccuracy{6.1, AbsoluteSupport::kGnss, kPhotos}));
  EXPECT_FALSE(RemarksOnPositions(no_angles.Map()).empty());
}

TEST(OpenLean, CountsWhereALogPlacesTheLineToo) {
  LineFlight line(0.0, true, false);
  for (auto& photo : line.flight.photos) photo.photo.position.reset();
  line.poses.photos_by_log = kPhotos;
  line.poses.log_position_sigma_m = 0.02;
  line.poses.log_is_corrected = true;
  EXPECT_EQ(JudgeMap(line.Map()).absolute, (AbsoluteAccuracy{1.1, AbsoluteSupport::kRtk, kPhotos}));
  EXPECT_FALSE(RemarksOnPositions(line.Map()).empty());
  for (auto& photo : line.flight.photos) photo.photo.attitude.reset();  // the body's, by the log
  EXPECT_EQ(JudgeMap(line.Map()).absolute, (AbsoluteAccuracy{2.2, AbsoluteSupport::kRtk, kPhotos}));
}

TEST(OpenLean, IsOpenBothWaysAtOneSpot) {
  const LineFlight flight(0.0, true, true);
  const OpenLean line = OpenLeanOf(flight.flight, {{0.0, 0.0}, {0.0, 100.0}}, 0.01, 5.0);
  const OpenLean spot = OpenLeanOf(flight.flight, {{0.0, 0.0}, {0.0, 0.0}}, 0.01, 5.0);
  EXPECT_NEAR(spot.off_m, 1.047, 0.001);  // 60 m by one degree
  EXPECT_NEAR(line.off_m, 0.741, 0.001);  // of two axes
  EXPECT_EQ(OpenLeanOf(flight.flight, {}, 0.01, 5.0).off_m, 0.0);
}

}  // namespace
}  // namespace skyquilt::pipeline
