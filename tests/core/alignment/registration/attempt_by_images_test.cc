// Simulated flights whose records are spoilt: what the photos show must do instead.
#include "core/alignment/attempts/attempt_by_images.h"

#include <gmock/gmock.h>

#include "core/alignment/estimators/sampler.h"
#include "core/base/median.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/alignment/simulated_case.h"

namespace skyquilt::alignment {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// As if the photos recorded nothing.
poses::PosedFlight Unplaced(const simulate::SimulatedFlight& truth) {
  poses::PosedFlight posed = PosesOf(truth);
  for (const poses::PosedPhoto& photo : posed.photos) {
    flight::Photo bare = photo.photo;
    bare.position.reset();
    bare.attitude.reset();
    posed.unplaced.push_back(bare);
    posed.left_out.push_back({bare.name, ErrorCode::kNoPosition, "has no position."});
  }
  posed.photos.clear();
  posed.is_placed = false;
  return posed;
}

// Taken for looking straight down, turned any way.
void ForgetAngles(poses::PosedFlight& posed) {
  Sampler sampler(3);
  for (poses::PosedPhoto& photo : posed.photos) {
    const double yaw = 0.01 * sampler.Below(628);
    Eigen::Matrix3d down;
    down << 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0;
    const Eigen::Quaterniond turned =
        Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())) * Eigen::Quaterniond(down);
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(turned.normalized(),
                                                                  photo.cam_from_enu.TargetOriginInSource());
    photo.covariance.topLeftCorner<3, 3>() = Eigen::Vector3d(0.01, 0.01, 9.0).asDiagonal();
    photo.attitude_origin = poses::AttitudeOrigin::kCourse;
  }
}

void ScaleHeights(double factor, poses::PosedFlight& posed) {
  for (poses::PosedPhoto& photo : posed.photos) {
    Eigen::Vector3d center = photo.cam_from_enu.TargetOriginInSource();
    center.z() = posed.ground_z_in_enu_m + factor * (center.z() - posed.ground_z_in_enu_m);
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(photo.cam_from_enu.rotation, center);
    photo.height_above_ground_m *= factor;
  }
}

TEST(WithUnplaced, TakesNoPositionThatIsOnlyRepeatedForARecord) {
  poses::PosedFlight posed;
  for (const bool is_repeated : {false, true}) {
    poses::PosedPhoto photo;
    photo.position_source = "exif";
    photo.photo.position.emplace().source = "exif";
    photo.photo.position->is_repeated = is_repeated;
    posed.photos.push_back(photo);
  }
  const ExtractedFlight whole = WithUnplaced(posed);
  EXPECT_TRUE(whole.records[0].center_in_enu);
  EXPECT_FALSE(whole.records[1].center_in_enu);
}

// A small flight with its records, which a case spoils.
class AttemptByImages : public testing::Test {
 protected:
  const simulate::SimulatedFlight truth_ = SmallTruth(16, 2.0);
  poses::PosedFlight posed_ = PosesOf(truth_);
};

TEST_F(AttemptByImages, GoodRecordsDoNotCallForIt) {
  const Outcome outcome = Align(truth_, posed_);
  EXPECT_EQ(outcome.report.aligned, 16);
  EXPECT_FALSE(outcome.report.by_images.why);
  EXPECT_EQ(outcome.report.by_images.pairs_compared, 0);
}

TEST_F(AttemptByImages, AFlightWithoutAnyRecordBecomesAWholeMapThatIsNotGeoreferenced) {
  const Outcome outcome = Align(truth_, Unplaced(truth_));
  EXPECT_EQ(outcome.report.aligned, 16);
  EXPECT_EQ(outcome.report.components, 1);
  EXPECT_TRUE(outcome.flight.left_out.empty());
  EXPECT_TRUE(outcome.report.by_images.is_taken);
  EXPECT_FALSE(outcome.report.by_images.is_placed);
  EXPECT_TRUE(outcome.report.by_images.is_scale_guessed.value_or(false));
  EXPECT_LT(outcome.error.relative_ce90_m, 1.5 * truth_.GsdM());
  ASSERT_FALSE(outcome.flight.warnings.empty());
  EXPECT_THAT(InWords(outcome.flight.warnings.front()),
              AllOf(HasSubstr("NOT GEOREFERENCED"), HasSubstr("its north is a guess"),
                    HasSubstr("its scale is as if a photo showed 100 m")));
}

// A flight whose positions were taken out, angles and heights left in.
TEST_F(AttemptByImages, AnglesAndHeightsWithoutPositionsTellNorthAndScale) {
  poses::PosedFlight posed = Unplaced(truth_);
  const poses::PosedFlight recorded = posed_;
  for (std::size_t i = 0; i < posed.unplaced.size(); ++i) {
    posed.unplaced[i].attitude = recorded.photos[i].photo.attitude;
    posed.unplaced[i].lone_height_above_takeoff_m = recorded.photos[i].height_above_ground_m;
  }
  ASSERT_TRUE(posed.unplaced.front().attitude);
  const Outcome outcome = Align(truth_, posed);
  EXPECT_EQ(outcome.report.aligned, 16);
  EXPECT_FALSE(outcome.report.by_images.is_placed);
  EXPECT_FALSE(outcome.report.by_images.is_scale_guessed);
  std::vector<double> ratios;
  for (const AlignedPhoto& photo : outcome.flight.photos)
    ratios.push_back(photo.height_above_ground_m / recorded.photos.front().height_above_ground_m);
  EXPECT_NEAR(Median(ratios), 1.0, 0.05);
  ASSERT_FALSE(outcome.flight.warnings.empty());
  EXPECT_THAT(InWords(outcome.flight.warnings.front()),
              AllOf(HasSubstr("NOT GEOREFERENCED"), HasSubstr("its north is as the cameras recorded it"),
                    HasSubstr("its scale is by the recorded heights")));
}

// Photos of two places: those of the second record it, those of the first nothing.
TEST_F(AttemptByImages, AGroupThatLiesNowhereIsNotDrawnOverPhotosThatLieSomewhere) {
  const simulate::SimulatedFlight truth = SmallTruth(24, 2.0);
  poses::PosedFlight posed = PosesOf(truth);
  const poses::PosedFlight bare = Unplaced(truth);
  // The first two lines of four and the last: nothing was taken of those between.
  posed.photos.erase(posed.photos.begin(), posed.photos.begin() + 20);
  posed.unplaced.assign(bare.unplaced.begin(), bare.unplaced.begin() + 8);
  posed.left_out.assign(bare.left_out.begin(), bare.left_out.begin() + 8);
  const Outcome outcome = Align(truth, posed);
  ASSERT_TRUE(outcome.report.by_images.is_taken);
  EXPECT_FALSE(outcome.report.by_images.is_placed);
  ASSERT_EQ(outcome.flight.photos.size(), 8u);
  ASSERT_EQ(outcome.flight.left_out.size(), 4u);
  for (const flight::LeftOutPhoto& photo : outcome.flight.left_out)
    EXPECT_EQ(photo.reason.code, flight::RemarkCode::kLeftBesideAdrift) << InWords(photo.reason);
}

TEST_F(AttemptByImages, APlaceThatWasReckonedFromNowhereIsNone) {
  posed_.is_placed = false;
  for (poses::PosedPhoto& photo : posed_.photos) photo.photo.position.reset();
  ForgetAngles(posed_);
  const Outcome outcome = Align(truth_, posed_);
  ASSERT_TRUE(outcome.report.by_images.is_taken);
  EXPECT_FALSE(outcome.report.by_images.is_placed);
  EXPECT_FALSE(outcome.report.by_images.is_adrift) << "photos lie to each other as reckoned";
  EXPECT_TRUE(outcome.flight.left_out.empty());
}

// A receiver that stood still.
TEST_F(AttemptByImages, RecordedHeightsTellTheScaleWherePositionsDoNot) {
  const auto span_m = [](const auto& photos) {
    const Eigen::Vector3d span = photos.back().cam_from_enu.TargetOriginInSource() -
                                 photos.front().cam_from_enu.TargetOriginInSource();
    return std::hypot(span.x(), span.y());
  };
  const double true_span_m = span_m(posed_.photos);
  const Eigen::Vector3d stood = posed_.photos[5].cam_from_enu.TargetOriginInSource();
  for (poses::PosedPhoto& photo : posed_.photos) {
    photo.photo.position->position = posed_.photos[5].photo.position->position;
    const double z_m = photo.cam_from_enu.TargetOriginInSource().z();
    photo.cam_from_enu =
        geo::Rigid3::FromRotationAndTargetOrigin(photo.cam_from_enu.rotation, {stood.x(), stood.y(), z_m});
  }
  const Outcome outcome = Align(truth_, posed_);
  ASSERT_TRUE(outcome.report.by_images.is_taken);
  EXPECT_FALSE(outcome.report.by_images.is_scale_guessed);
  ASSERT_EQ(outcome.flight.photos.size(), 16u);
  EXPECT_NEAR(span_m(outcome.flight.photos) / true_span_m, 1.0, 0.1);
}

TEST_F(AttemptByImages, TwoPhotosWithoutPlacesAreToldThatItTakesThree) {
  poses::PosedFlight posed = Unplaced(truth_);
  posed.unplaced.resize(2);
  posed.left_out.resize(2);
  AlignReport report;
  SilentProgress progress;
  EXPECT_THAT(test::ErrorOf(AlignFlight(posed, test::PhotosOf(truth_), {}, report, progress)).message,
              HasSubstr("three photos or more"));
}

// Of a line: ten photos, and after a gap two more that share a strip with the tenth and no point with two
// others.
TEST_F(AttemptByImages, PhotosThatHangOnOneOtherAreTakenIn) {
  simulate::SimulateOptions options;
  options.seed = options.world.seed = 8;
  options.noise = simulate::NoiseClass::kExact;
  options.intrinsics = camera::Intrinsics::Centered(800, 600, 750.0);
  options.world.relief_m = 24.0;  // so steep that no level ground holds the two either
  options.trajectory.front_overlap = 0.72;
  options.trajectory.photos = options.trajectory.photos_per_line = 14;
  const simulate::SimulatedFlight truth = *simulate::PlanSimulatedFlight(options);
  poses::PosedFlight posed = Unplaced(truth);
  posed.unplaced.erase(posed.unplaced.begin() + 10, posed.unplaced.begin() + 12);
  posed.left_out.erase(posed.left_out.begin() + 10, posed.left_out.begin() + 12);
  const Outcome outcome = Align(truth, posed);
  EXPECT_EQ(outcome.report.aligned, 12);
  EXPECT_EQ(outcome.report.components, 1);
  EXPECT_TRUE(outcome.flight.left_out.empty());
  EXPECT_EQ(outcome.report.by_images.registered, 12);
}

TEST_F(AttemptByImages, SurveyedPointsAlonePlaceIt) {
  AlignOptions options;
  options.control = SurveyControl(truth_);
  const Outcome outcome = Align(truth_, Unplaced(truth_), options);
  EXPECT_EQ(outcome.report.aligned, 16);
  EXPECT_TRUE(outcome.report.by_images.is_placed);
  EXPECT_LT(outcome.error.absolute_ce90_m, 2.0 * truth_.GsdM());
}

TEST_F(AttemptByImages, HeightsOfAnotherScaleAreFoundFromThePictures) {
  for (const double factor : {0.4, 0.7, 1.8}) {
    poses::PosedFlight posed = PosesOf(truth_);
    ScaleHeights(factor, posed);
    const Outcome outcome = Align(truth_, posed);
    EXPECT_EQ(outcome.report.aligned, 16) << factor;
    EXPECT_EQ(outcome.report.components, 1) << factor;
    EXPECT_LT(outcome.error.relative_ce90_m, 1.5 * truth_.GsdM()) << factor;
    // After a similarity any size is right: the recorded positions say which.
    EXPECT_LT(outcome.error.absolute_ce90_m, 4.0) << factor;
  }
}

TEST_F(AttemptByImages, AnglesThatAreNotRecordedAreFoundFromThePictures) {
  ForgetAngles(posed_);
  ScaleHeights(0.5, posed_);
  const Outcome outcome = Align(truth_, posed_);
  EXPECT_EQ(outcome.report.aligned, 16);
  EXPECT_EQ(outcome.report.components, 1);
  EXPECT_LT(outcome.error.relative_ce90_m, 1.5 * truth_.GsdM());
}

TEST_F(AttemptByImages, AThirdOfThePositionsMayBeFiftyMetresOff) {
  ForgetAngles(posed_);
  for (std::size_t i = 0; i < posed_.photos.size(); i += 3) {
    Eigen::Vector3d center = posed_.photos[i].cam_from_enu.TargetOriginInSource();
    center.head<2>() += 50.0 * Eigen::Vector2d(std::cos(2.0 * i), std::sin(2.0 * i));
    posed_.photos[i].cam_from_enu =
        geo::Rigid3::FromRotationAndTargetOrigin(posed_.photos[i].cam_from_enu.rotation, center);
  }
  const Outcome outcome = Align(truth_, posed_);
  EXPECT_EQ(outcome.report.aligned, 16);
  EXPECT_LT(outcome.error.relative_ce90_m, 1.5 * truth_.GsdM());
  EXPECT_LT(outcome.error.absolute_ce90_m, 4.0);
}

// Without position or height, among others that are fine.
poses::PosedFlight WithoutRecords(const poses::PosedFlight& whole, const std::vector<std::size_t>& lost) {
  poses::PosedFlight posed = whole;
  for (auto i = lost.rbegin(); i != lost.rend(); ++i) {
    flight::Photo photo = posed.photos[*i].photo;
    photo.position.reset();
    posed.left_out.push_back({photo.name, ErrorCode::kNoPosition, "has no position."});
    posed.unplaced.push_back(std::move(photo));
    posed.photos.erase(posed.photos.begin() + static_cast<std::ptrdiff_t>(*i));
  }
  return posed;
}

TEST_F(AttemptByImages, AFewLostPhotosAreRegisteredAgainstTheOthers) {
  const Outcome outcome = Align(truth_, WithoutRecords(posed_, {5, 6, 9}));
  EXPECT_EQ(outcome.report.aligned, 16);
  EXPECT_EQ(outcome.report.components, 1);
  EXPECT_TRUE(outcome.flight.left_out.empty());
  // The others stay where their records and the photos have them.
  EXPECT_FALSE(outcome.report.by_images.why);
  EXPECT_FALSE(outcome.report.by_images.is_taken);
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(outcome.report.photo_reports[i].is_by_images, i == 5 || i == 6 || i == 9) << i;
  }
  EXPECT_LT(outcome.error.relative_ce90_m, 1.5 * truth_.GsdM());
}

TEST_F(AttemptByImages, APhotoRecordedFarAwayComesBack) {
  geo::Rigid3& pose = posed_.photos[6].cam_from_enu;
  const Eigen::Quaterniond turned =
      Eigen::Quaterniond(Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ())) * pose.rotation;
  pose = geo::Rigid3::FromRotationAndTargetOrigin(
      turned.normalized(), pose.TargetOriginInSource() + Eigen::Vector3d(900.0, 400.0, 0.0));
  const Outcome outcome = Align(truth_, posed_);
  EXPECT_EQ(outcome.report.aligned, 16);
  EXPECT_EQ(outcome.report.components, 1);
  EXPECT_FALSE(outcome.report.by_images.is_taken);
  EXPECT_LT(outcome.error.relative_ce90_m, 1.5 * truth_.GsdM());
}

TEST_F(AttemptByImages, APhotoRecordedFarAwayJoinsPhotosThatStay) {
  const poses::PosedFlight right = posed_;
  poses::PosedFlight posed = right;
  constexpr std::size_t kAdded = 15;
  geo::Rigid3& pose = posed.photos[kAdded].cam_from_enu;
  pose = geo::Rigid3::FromRotationAndTargetOrigin(
      pose.rotation, pose.TargetOriginInSource() + Eigen::Vector3d(900.0, 400.0, 0.0));
  AlignOptions options;
  options.fixed = PhotoSet(16, true);
  options.fixed.Remove(kAdded);
  const Outcome outcome = Align(truth_, posed, options);
  ASSERT_EQ(outcome.flight.photos.size(), 16U);
  EXPECT_EQ(outcome.report.aligned, 16);
  for (std::size_t i = 0; i < 16; ++i) {
    const double off_m = (outcome.flight.photos[i].cam_from_enu.TargetOriginInSource() -
                          right.photos[i].cam_from_enu.TargetOriginInSource())
                             .norm();
    EXPECT_LT(off_m, i == kAdded ? 2.0 : 1e-9) << i;
  }
}

TEST_F(AttemptByImages, PhotosWithoutHeightJoinTheOthers) {
  const poses::PosedFlight whole = posed_;
  posed_.photos.erase(posed_.photos.begin() + 5, posed_.photos.begin() + 8);
  for (std::size_t i = 5; i < 8; ++i) {
    posed_.unplaced.push_back(whole.photos[i].photo);
    posed_.left_out.push_back({whole.photos[i].photo.name, ErrorCode::kNoPosition, "has no usable height."});
  }
  const Outcome outcome = Align(truth_, posed_);
  EXPECT_EQ(outcome.report.photos, 16);
  EXPECT_EQ(outcome.report.aligned, 16);
  EXPECT_TRUE(outcome.flight.left_out.empty());
  for (std::size_t i = 0; i < 16; ++i)
    EXPECT_EQ(outcome.flight.photos[i].photo.name, whole.photos[i].photo.name);
  EXPECT_LT(outcome.error.relative_ce90_m, 1.5 * truth_.GsdM());
}

TEST_F(AttemptByImages, PhotosThatShowNothingStayLeftOut) {
  flight::Photo foreign = posed_.photos[3].photo;
  foreign.name = "foreign.jpg";
  foreign.path = "foreign.jpg";
  foreign.position.reset();
  posed_.unplaced.push_back(foreign);
  posed_.left_out.push_back({foreign.name, ErrorCode::kNoPosition, "has no position."});
  const Outcome outcome = Align(truth_, posed_);
  EXPECT_EQ(outcome.report.aligned, 16);
  EXPECT_EQ(outcome.report.photos, 16);
  ASSERT_EQ(outcome.flight.left_out.size(), 1U);
  EXPECT_EQ(outcome.flight.left_out.front().name, "foreign.jpg");
}

}  // namespace
}  // namespace skyquilt::alignment
