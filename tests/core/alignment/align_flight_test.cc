#include "core/alignment/align_flight.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "core/alignment/align_by_pose.h"
#include "core/alignment/bundle/readout_motion.h"
#include "core/flight/remarks/remark_words.h"
#include "core/simulate/sensors/recorded_pose.h"
#include "tests/core/alignment/simulated_case.h"

namespace skyquilt::alignment {
namespace {

// A camera that reads its rows one after another bends what it sees by its speed.
TEST(AlignFlight, UndoesTheRollingShutterThatItIsToldOf) {
  simulate::SimulateOptions options = SmallTruth(8, 0.0).options;
  options.readout_s = 0.06;
  const simulate::SimulatedFlight truth = *simulate::PlanSimulatedFlight(options);
  poses::PosedFlight posed = PosesOf(truth);
  const Outcome untold = Align(truth, posed);
  for (poses::PosedPhoto& photo : posed.photos) photo.photo.readout_s = options.readout_s;
  const Outcome told = Align(truth, posed);
  EXPECT_EQ(told.report.aligned, 8);
  EXPECT_LT(told.error.relative_ce90_m, 0.5 * truth.GsdM());
  EXPECT_LT(2.0 * told.error.relative_ce90_m, untold.error.relative_ce90_m);
  for (std::size_t i = 0; i < 8; ++i) {
    const Eigen::Vector3d truly_m = options.readout_s * truth.photos[i].pose.velocity_in_enu_mps;
    EXPECT_LT((told.flight.photos[i].readout_motion.shift_in_enu_m - truly_m).norm(), 0.01);
  }
}

// Flown to and fro with the camera turned one way, the lines are stretched against each other.
TEST(AlignFlight, FindsTheRollingShutterThatNobodyRecorded) {
  simulate::SimulateOptions options = SmallTruth(12, 0.0).options;
  options.readout_s = 0.06;
  options.trajectory.yaw_rule = simulate::YawRule::kFixed;
  const simulate::SimulatedFlight truth = *simulate::PlanSimulatedFlight(options);
  const Outcome found = Align(truth, PosesOf(truth));
  EXPECT_EQ(found.report.aligned, 12);
  EXPECT_LT(found.error.relative_ce90_m, truth.GsdM());
  const auto& told = found.report.corrections;
  EXPECT_TRUE(std::any_of(told.begin(), told.end(), [](const flight::Remark& one) {
    return one.code == flight::RemarkCode::kRollingShutterFound;
  }));
}

// One that also turns meanwhile, with a gyro that lags by a little that nobody tells.
TEST(AlignFlight, UndoesTheTurningDuringTheReadoutByTheGyro) {
  simulate::SimulateOptions options = SmallTruth(8, 0.0).options;
  options.readout_s = 0.12;
  options.shaking_radps = 0.2;
  options.has_gyro = true;
  const simulate::SimulatedFlight truth = *simulate::PlanSimulatedFlight(options);
  const poses::PosedFlight posed = PosesOf(truth);
  const Outcome told = Align(truth, posed);
  poses::PosedFlight bare = posed;
  for (poses::PosedPhoto& photo : bare.photos) photo.photo.turning.reset();
  const Outcome untold = Align(truth, bare);
  EXPECT_EQ(told.report.aligned, 8);
  ASSERT_EQ(told.report.gyros.size(), 1U);
  EXPECT_TRUE(told.report.gyros.front().is_used);
  EXPECT_NEAR(told.report.gyros.front().lag_s, simulate::kGyroLagS, 0.004);
  EXPECT_TRUE(untold.report.gyros.empty());
  EXPECT_LT(told.error.relative_ce90_m, truth.GsdM());
  EXPECT_LT(4.0 * told.error.relative_ce90_m, untold.error.relative_ce90_m);
}

TEST(ReadoutMotion, KnowsPicturesThatAViewerTurned) {
  poses::PosedPhoto posed;
  EXPECT_TRUE(ReadoutMotion(posed, 0).IsStill());
  posed.photo.readout_s = 0.05;
  EXPECT_TRUE(ReadoutMotion(posed, 0).IsStill());
  posed.velocity_in_enu_mps = Eigen::Vector3d(4.0, -2.0, 0.0);
  const Eigen::Vector3d motion_m(0.2, -0.1, 0.0);
  EXPECT_TRUE(ReadoutMotion(posed, 0).shift_in_enu_m.isApprox(motion_m));
  EXPECT_TRUE(ReadoutMotion(posed, 2).shift_in_enu_m.isApprox(motion_m));  // the camera is mounted so
  posed.photo.is_resaved_by_viewer = true;
  EXPECT_TRUE(ReadoutMotion(posed, 0).shift_in_enu_m.isApprox(motion_m));
  EXPECT_TRUE(ReadoutMotion(posed, 2).shift_in_enu_m.isApprox(-motion_m));
  EXPECT_TRUE(ReadoutMotion(posed, 1).IsStill());  // its rows lie across now
}

void TurnAboutAxis(poses::PosedPhoto& photo, double angle_rad) {
  const Eigen::Vector3d center = photo.cam_from_enu.TargetOriginInSource();
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()));
  photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(turn * photo.cam_from_enu.rotation, center);
}

TEST(AlignFlight, BringsPhotosToWithinTwoPixelsOfEachOtherOnFlatGround) {
  const simulate::SimulatedFlight truth = SmallTruth(8, 0.0);
  const poses::PosedFlight posed = PosesOf(truth);
  const Outcome outcome = Align(truth, posed);
  EXPECT_EQ(outcome.report.aligned, 8);
  EXPECT_EQ(outcome.report.components, 1);
  EXPECT_LT(outcome.error.relative_ce90_m, 2.0 * truth.GsdM());
  const GroundError by_pose = MeasureGroundError(truth, AlignByPoseOnly(posed),
                                                 ground::GroundSurface::Plane(posed.ground_z_in_enu_m));
  EXPECT_LT(outcome.error.absolute_ce90_m, 1.1 * by_pose.absolute_ce90_m);
}

TEST(AlignFlight, HoldsOnReliefToo) {
  const simulate::SimulatedFlight truth = SmallTruth(8, 8.0);
  const Outcome outcome = Align(truth, PosesOf(truth));
  EXPECT_EQ(outcome.report.aligned, 8);
  EXPECT_LT(outcome.error.relative_ce90_m, 5.0 * truth.GsdM());
}

TEST(AlignFlight, FindsTheDistortionOfALensWhoseFocalLengthAloneIsRecorded) {
  simulate::SimulateOptions options = SmallTruth(12, 0.0).options;
  options.intrinsics.k1 = -0.08;
  options.intrinsics.k2 = 0.03;
  const simulate::SimulatedFlight truth = *simulate::PlanSimulatedFlight(options);
  const Outcome outcome = Align(truth, PosesOf(truth));
  EXPECT_EQ(outcome.report.aligned, 12);
  ASSERT_EQ(outcome.report.lenses.size(), 1u);
  EXPECT_EQ(outcome.report.lenses.front().recorded.k1, 0.0);
  EXPECT_NEAR(outcome.report.lenses.front().adjusted.k1, -0.08, 0.012);
}

TEST(AlignFlight, GivesTheSameBytesOnOneThreadAndOnTwo) {
  const simulate::SimulatedFlight truth = SmallTruth(8, 0.0);
  const poses::PosedFlight posed = PosesOf(truth);
  AlignOptions alone;
  alone.threads = 1;
  const AlignedFlight one = Align(truth, posed, alone).flight;
  const AlignedFlight two = Align(truth, posed).flight;
  ASSERT_EQ(one.photos.size(), two.photos.size());
  for (std::size_t i = 0; i < one.photos.size(); ++i) {
    EXPECT_EQ(one.photos[i].cam_from_enu.rotation.coeffs(), two.photos[i].cam_from_enu.rotation.coeffs());
    EXPECT_EQ(one.photos[i].cam_from_enu.translation, two.photos[i].cam_from_enu.translation);
    EXPECT_EQ(one.photos[i].intrinsics, two.photos[i].intrinsics);
  }
  EXPECT_EQ(one.tie_points_in_enu, two.tie_points_in_enu);
}

TEST(AlignFlight, FindsALineThatIsStoredTurnedUpsideDown) {
  const simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  poses::PosedFlight posed = PosesOf(truth);
  for (int i = 4; i < 8; ++i) TurnAboutAxis(posed.photos[i], std::numbers::pi);
  const Outcome outcome = Align(truth, posed);
  EXPECT_EQ(outcome.report.aligned, 12);
  ASSERT_FALSE(outcome.report.corrections.empty());
  EXPECT_NE(InWords(outcome.report.corrections.front()).find("180"), std::string::npos);
  EXPECT_LT(outcome.error.relative_ce90_m, 2.0 * truth.GsdM());
}

TEST(AlignFlight, FindsThatTheCameraIsMountedTurned) {
  const simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  for (const double turn : {0.5, 1.0, -0.5}) {
    poses::PosedFlight posed = PosesOf(truth);
    for (poses::PosedPhoto& photo : posed.photos) TurnAboutAxis(photo, turn * std::numbers::pi);
    const Outcome outcome = Align(truth, posed);
    EXPECT_EQ(outcome.report.aligned, 12) << turn;
    EXPECT_FALSE(outcome.report.corrections.empty()) << turn;
    EXPECT_LT(outcome.error.relative_ce90_m, 2.0 * truth.GsdM()) << turn;
    EXPECT_LT(outcome.error.absolute_ce90_m, 5.0) << turn;
  }
}

TEST(AlignFlight, FindsPositionsFarOffAndYawOfSomethingElse) {
  const simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  poses::PosedFlight posed = PosesOf(truth);
  poses::PosedPhoto& astray = posed.photos[5];
  astray.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
      astray.cam_from_enu.rotation,
      astray.cam_from_enu.TargetOriginInSource() + Eigen::Vector3d(40.0, 30.0, 0.0));
  TurnAboutAxis(posed.photos[9], 0.5 * std::numbers::pi);
  const Outcome outcome = Align(truth, posed);
  EXPECT_EQ(outcome.report.aligned, 12);
  EXPECT_LT(outcome.error.relative_ce90_m, 2.0 * truth.GsdM());
  EXPECT_NE(InOneLine(outcome.flight.photos[5].placement_remarks).find("position"), std::string::npos);
  EXPECT_NE(InOneLine(outcome.flight.photos[9].placement_remarks).find("turned"), std::string::npos);
}

bool HasFault(const AlignReport& report, const std::string& name, PhotoFault fault) {
  const auto photo = std::find_if(report.photo_reports.begin(), report.photo_reports.end(),
                                  [&](const AlignPhotoReport& one) { return one.name == name; });
  if (photo == report.photo_reports.end()) return false;
  return std::find(photo->faults.begin(), photo->faults.end(), fault) != photo->faults.end();
}

// One photo shows another world.
class AstraySource final : public flight::PhotoSource {
 public:
  AstraySource(const simulate::SimulatedFlight& truth, std::string astray)
      : source_(test::PhotosOf(truth)), other_(truth), astray_(std::move(astray)) {
    simulate::WorldOptions world = truth.options.world;
    world.seed += 1000;
    other_.world = simulate::World(world);
  }
  Result<image::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override {
    if (photo.name != astray_) return source_.Decode(photo, denominator);
    return test::PhotosOf(other_).Decode(photo, denominator);
  }

 private:
  simulate::SimulatedPhotoSource source_;
  simulate::SimulatedFlight other_;
  std::string astray_;
};

TEST(AlignFlight, TellsABlurredPhotoFromOneOfAnotherPlaceAndAccusesNoOther) {
  simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  truth.photos[5].render.motion_in_enu_m = Eigen::Vector3d(2.5, 1.5, 0.0);
  const std::string blurred = truth.photos[5].photo.name, astray = truth.photos[6].photo.name;
  AlignReport report;
  SilentProgress progress;
  const auto aligned =
      test::ValueOf(AlignFlight(PosesOf(truth), AstraySource(truth, astray), {}, report, progress));
  EXPECT_TRUE(HasFault(report, blurred, PhotoFault::kBlurred));
  EXPECT_FALSE(HasFault(report, blurred, PhotoFault::kOtherPlace));
  EXPECT_TRUE(HasFault(report, astray, PhotoFault::kOtherPlace));
  EXPECT_FALSE(HasFault(report, astray, PhotoFault::kBlurred));
  for (const AlignPhotoReport& photo : report.photo_reports) {
    EXPECT_EQ(photo.faults.empty(), photo.name != blurred && photo.name != astray) << photo.name;
  }
  EXPECT_FALSE(report.pairs.empty());
  for (const AlignPairReport& pair : report.pairs) {
    EXPECT_NE(pair.first, astray);
    EXPECT_NE(pair.second, astray);
    EXPECT_LT(pair.rms_px, 5.0);
  }
}

// Hands one photo the picture of nothing and another a damaged file.
class SpoiltSource final : public flight::PhotoSource {
 public:
  explicit SpoiltSource(const simulate::SimulatedFlight& truth)
      : truth_(truth), source_(test::PhotosOf(truth)) {}
  Result<image::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override {
    if (photo.name == truth_.photos[3].photo.name)
      return Error{ErrorCode::kCorrupt, "the file is cut off", ""};
    Result<image::DecodedImage> image = source_.Decode(photo, denominator);
    if (image && photo.name == truth_.photos[6].photo.name) {
      std::fill(image->rgb.begin(), image->rgb.end(), std::uint8_t{90});
    }
    return image;
  }

 private:
  const simulate::SimulatedFlight& truth_;
  simulate::SimulatedPhotoSource source_;
};

TEST(AlignFlight, KeepsPhotosItCannotMatchAtTheirPose) {
  const simulate::SimulatedFlight truth = SmallTruth(8, 0.0);
  const poses::PosedFlight posed = PosesOf(truth);
  AlignReport report;
  SilentProgress progress;
  const auto aligned = test::ValueOf(AlignFlight(posed, SpoiltSource(truth), {}, report, progress));
  ASSERT_EQ(aligned.photos.size(), 8u);
  EXPECT_EQ(report.aligned, 6);
  for (const int i : {3, 6}) {
    EXPECT_EQ(aligned.photos[i].placement, Placement::kPoseOnly);
    ASSERT_FALSE(aligned.photos[i].placement_remarks.empty());
    EXPECT_EQ(aligned.photos[i].placement_remarks[0].code == flight::RemarkCode::kByPoseUnreadable, i == 3);
    EXPECT_GT(aligned.photos[i].error_radius_m, 0.0);
    EXPECT_LT((aligned.photos[i].cam_from_enu.TargetOriginInSource() -
               posed.photos[i].cam_from_enu.TargetOriginInSource())
                  .norm(),
              6.0);
  }
  EXPECT_NE(InOneLine(aligned.photos[3].placement_remarks).find("cut off"), std::string::npos);
  // Looking straight down a photo is tied as far out as its border, and one without ties nowhere.
  for (const int i : {0, 1, 2, 4, 5, 7}) {
    const camera::Intrinsics& lens = aligned.photos[i].intrinsics;
    const double corner_rad = std::atan(std::hypot(lens.width_px, lens.height_px) / 2.0 / lens.focal_x_px);
    EXPECT_GT(aligned.photos[i].tied_look_rad, 0.5 * corner_rad);
    EXPECT_LT(aligned.photos[i].tied_look_rad, corner_rad + 0.05);
  }
  for (const int i : {3, 6}) EXPECT_EQ(aligned.photos[i].tied_look_rad, 0.0);
}

TEST(AlignFlight, LimitsNoLookWhereNothingIsTied) {
  const simulate::SimulatedFlight truth = SmallTruth(2, 0.0);
  poses::PosedFlight posed = PosesOf(truth);
  posed.photos.resize(1);
  const Outcome outcome = Align(truth, posed);
  ASSERT_EQ(outcome.flight.photos.size(), 1u);
  EXPECT_DOUBLE_EQ(outcome.flight.photos[0].tied_look_rad, 0.5 * std::numbers::pi);
}

TEST(AlignFlight, TakesAFlightOfNoneAndOfOne) {
  const simulate::SimulatedFlight truth = SmallTruth(2, 0.0);
  poses::PosedFlight posed = PosesOf(truth);
  posed.photos.resize(1);
  EXPECT_EQ(Align(truth, posed).flight.photos.size(), 1u);
  posed.photos.clear();
  AlignReport report;
  SilentProgress progress;
  const auto none = test::ValueOf(AlignFlight(posed, test::PhotosOf(truth), {}, report, progress));
  EXPECT_TRUE(none.photos.empty());
}

}  // namespace
}  // namespace skyquilt::alignment
