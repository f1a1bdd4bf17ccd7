// The methods that AlignFlight is compared with: each must do what it stands for, or the comparison is worth
// nothing.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/alignment/baselines/align_by_features.h"
#include "core/alignment/baselines/align_by_pose.h"
#include "core/alignment/baselines/align_directly.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/alignment/simulated_case.h"
#include "tests/support/value_of.h"

namespace skyquilt::alignment {
namespace {

AlignOptions OnThreads(int threads) {
  AlignOptions options;
  options.features.max_features = 800;
  options.threads = threads;
  return options;
}

GroundError ErrorOf(const simulate::SimulatedFlight& truth, const AlignedFlight& flight) {
  return MeasureGroundError(truth, flight, ground::GroundSurface::Plane(flight.ground_z_in_enu_m));
}

TEST(AlignByFeatures, ChainsAFlightOverFlatGroundTighterThanItsPosesAre) {
  const simulate::SimulatedFlight truth = SmallTruth(8, 0.0);
  const poses::PosedFlight posed = PosesOf(truth);
  AlignReport report;
  SilentProgress progress;
  const auto flight =
      test::ValueOf(AlignByFeatures(posed, test::PhotosOf(truth), OnThreads(2), report, progress));
  EXPECT_EQ(flight.photos.size(), 8U);
  EXPECT_EQ(report.components, 1);
  EXPECT_LT(ErrorOf(truth, flight).relative_ce90_m, 5.0 * truth.GsdM());
  EXPECT_GT(ErrorOf(truth, AlignByPoseOnly(posed)).relative_ce90_m, 10.0 * truth.GsdM());
}

TEST(AlignByFeatures, LooksAtNoRecordedAngle) {
  const simulate::SimulatedFlight truth = SmallTruth(8, 0.0);
  poses::PosedFlight posed = PosesOf(truth);
  AlignReport report;
  SilentProgress progress;
  const simulate::SimulatedPhotoSource source = test::PhotosOf(truth);
  const auto before = AlignByFeatures(posed, source, OnThreads(2), report, progress);
  for (poses::PosedPhoto& photo : posed.photos) {
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
        Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitX()) * photo.cam_from_enu.rotation,
        photo.cam_from_enu.TargetOriginInSource());
  }
  const auto after = AlignByFeatures(posed, source, OnThreads(1), report, progress);
  ASSERT_TRUE(before.ok() && after.ok());
  ASSERT_EQ(before->photos.size(), after->photos.size());
  for (std::size_t i = 0; i < before->photos.size(); ++i) {
    EXPECT_TRUE(
        before->photos[i].cam_from_enu.rotation.isApprox(after->photos[i].cam_from_enu.rotation, 1e-12));
  }
}

// Replaces one photo's picture by that of another world.
class OneElsewhere final : public flight::PhotoSource {
 public:
  OneElsewhere(const simulate::SimulatedFlight& here, const simulate::SimulatedFlight& elsewhere,
               std::string name)
      : here_(test::PhotosOf(here)), elsewhere_(test::PhotosOf(elsewhere)), name_(std::move(name)) {}
  Result<image::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override {
    return photo.name == name_ ? elsewhere_.Decode(photo, denominator) : here_.Decode(photo, denominator);
  }

 private:
  simulate::SimulatedPhotoSource here_, elsewhere_;
  std::string name_;
};

TEST(AlignByFeatures, LeavesOutAPhotoThatMatchesNoOther) {
  const simulate::SimulatedFlight truth = SmallTruth(8, 0.0);
  simulate::SimulateOptions other = SmallTruth(8, 0.0).options;
  other.world.seed = 99;
  const auto elsewhere = PlanSimulatedFlight(other);
  const poses::PosedFlight posed = PosesOf(truth);
  const std::string odd = posed.photos[2].photo.name;
  AlignReport report;
  SilentProgress progress;
  const auto flight = test::ValueOf(
      AlignByFeatures(posed, OneElsewhere(truth, *elsewhere, odd), OnThreads(2), report, progress));
  EXPECT_EQ(flight.photos.size(), 7U);
  ASSERT_EQ(flight.left_out.size(), 1U);
  EXPECT_EQ(flight.left_out.front().name, odd);
  EXPECT_FALSE(InWords(flight.left_out.front().reason).empty());
}

TEST(AlignDirectly, MovesPhotosTogetherThatPosesLeaveApart) {
  const simulate::SimulatedFlight truth = SmallTruth(8, 0.0);
  const poses::PosedFlight posed = PosesOf(truth);
  AlignReport report;
  SilentProgress progress;
  const auto flight =
      test::ValueOf(AlignDirectly(posed, test::PhotosOf(truth), OnThreads(2), report, progress));
  EXPECT_EQ(flight.photos.size(), 8U);
  EXPECT_GT(report.aligned, 5);
  for (const AlignPhotoReport& photo : report.photo_reports) EXPECT_EQ(photo.features, 0);
  EXPECT_LT(ErrorOf(truth, flight).relative_ce90_m,
            0.7 * ErrorOf(truth, AlignByPoseOnly(posed)).relative_ce90_m);
}

}  // namespace
}  // namespace skyquilt::alignment
