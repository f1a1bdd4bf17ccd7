#include "core/alignment/from_records/correct_poses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <utility>

#include "core/alignment/scene/view.h"
#include "core/flight/remarks/remark_words.h"

namespace skyquilt::alignment {
namespace {

// 60 m up, leaning by the given angle to the east.
poses::PosedPhoto Leaning(double lean_rad) {
  poses::PosedPhoto posed;
  posed.photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  const Eigen::Quaterniond down(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond lean(Eigen::AngleAxisd(-lean_rad, Eigen::Vector3d::UnitY()));
  posed.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(down * lean.conjugate(), {0.0, 0.0, 60.0});
  posed.height_above_ground_m = 60.0;
  posed.covariance.diagonal() << 1e-3, 1e-3, 3e-3, 2.0, 2.0, 1.0;
  return posed;
}

std::complex<double> MiddleOf(const poses::PosedPhoto& posed, const geo::Rigid3& cam_from_enu) {
  const View view{posed.photo.intrinsics, cam_from_enu, 60.0, {}};
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  EXPECT_TRUE(MeetGround(view, Relief(0.0),
                         {posed.photo.intrinsics.center_x_px, posed.photo.intrinsics.center_y_px}, &middle));
  return {middle.x(), middle.y()};
}

PhotoGround GroundWith(double sigma_m, std::complex<double> turn, std::complex<double> shift,
                       int component = 0) {
  return {{0.0, 0.0}, sigma_m, 0.1, 1.0, {turn, shift}, component};
}

TEST(CorrectPose, LaysTheMiddleOfALeaningPhotoWhereTheGraphWantsIt) {
  for (const double lean_rad : {0.0, 0.1, 0.3}) {
    const poses::PosedPhoto posed = Leaning(lean_rad);
    PhotoGround wanted{MiddleOf(posed, posed.cam_from_enu), 5.0, 0.1};
    wanted.correction = {std::polar(1.05, 0.3), {8.0, -6.0}};
    wanted.component = 0;
    const PhotoFindings corrected = CorrectPose(posed, wanted);
    const std::complex<double> error =
        MiddleOf(posed, corrected.start_cam_from_enu) - (wanted.middle + wanted.correction.shift);
    EXPECT_LT(std::abs(error), 0.1) << "leaning " << lean_rad;
    EXPECT_FALSE(corrected.position_was_wrong);
  }
}

TEST(CorrectPose, CallsAPositionWrongOnlyBeyondWhatTheFlightsRecordsAreWorth) {
  const poses::PosedPhoto posed = Leaning(0.0);
  EXPECT_TRUE(CorrectPose(posed, GroundWith(2.0, 1.0, 20.0)).position_was_wrong);
  EXPECT_FALSE(CorrectPose(posed, GroundWith(8.0, 1.0, 20.0)).position_was_wrong);
}

TEST(CorrectPose, LeavesAPhotoWithoutVerifiedPairsAsItWasRecorded) {
  const poses::PosedPhoto posed = Leaning(0.1);
  const PhotoFindings corrected = CorrectPose(posed, GroundWith(2.0, {0.0, 1.0}, {9.0, 9.0}, -1));
  EXPECT_TRUE(corrected.start_cam_from_enu.rotation.isApprox(posed.cam_from_enu.rotation));
  EXPECT_TRUE(corrected.notes.empty());
}

// Nothing was recorded that a photo could contradict where the course of the flight stood for its yaw.
TEST(CorrectPose, SaysAgainstWhatPhotosLieTurned) {
  poses::PosedPhoto posed = Leaning(0.0);
  const PhotoGround half_turn = GroundWith(5.0, -1.0, 0.0), kept = GroundWith(5.0, 1.0, 0.0);
  for (const auto& [origin, words] : {std::pair{poses::AttitudeOrigin::kRecorded, "their recorded yaw"},
                                      std::pair{poses::AttitudeOrigin::kCourse, "the flight's course"}}) {
    posed.attitude_origin = origin;
    const PhotoFindings turned = CorrectPose(posed, half_turn), as_is = CorrectPose(posed, kept);
    const auto sentences = InWords(DescribeCorrections({turned, turned, as_is}, {"a", "b", "c"}, {0, 0, 0}));
    ASSERT_EQ(sentences.size(), 1u);
    EXPECT_NE(sentences[0].find(std::string("turned by 180 degrees against ") + words), std::string::npos)
        << sentences[0];
  }
}

// A row of photos by the course alone, east and then north; one lies across.
TEST(CorrectPose, BlamesNoPictureForTheBendOfACourse) {
  const PhotoGround across = GroundWith(5.0, {0.0, 1.0}, 0.0), kept = GroundWith(5.0, 1.0, 0.0);
  const auto said_of = [&](std::size_t turned, poses::AttitudeOrigin origin) {
    std::vector<poses::PosedPhoto> recorded;
    std::vector<PhotoFindings> corrected;
    for (std::size_t i = 0; i < 9; ++i) {
      poses::PosedPhoto posed = Leaning(0.0);
      posed.attitude_origin = origin;
      corrected.push_back(CorrectPose(posed, i == turned ? across : kept));
      const double east_m = 20.0 * static_cast<double>(std::min<std::size_t>(i, 4));
      const double north_m = i > 4 ? 20.0 * static_cast<double>(i - 4) : 0.0;
      posed.cam_from_enu =
          geo::Rigid3::FromRotationAndTargetOrigin(posed.cam_from_enu.rotation, {east_m, north_m, 60.0});
      recorded.push_back(posed);
    }
    ForgiveTurnsAtBends(recorded, corrected);
    const std::vector<std::string> names(9, "a");
    return DescribeCorrections(corrected, names, {0, 0, 0, 0, 0, 1, 1, 1, 1}).size();
  };
  EXPECT_EQ(said_of(4, poses::AttitudeOrigin::kCourse), 0u);
  EXPECT_EQ(said_of(2, poses::AttitudeOrigin::kCourse), 1u) << "on a straight line";
  EXPECT_EQ(said_of(4, poses::AttitudeOrigin::kRecorded), 1u) << "against its own record";
}

}  // namespace
}  // namespace skyquilt::alignment
