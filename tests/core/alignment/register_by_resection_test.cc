#include "core/alignment/from_records/register_by_resection.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/alignment/from_records/bundle_setup.h"
#include "tests/core/alignment/simulated_case.h"
#include "tests/support/rendered_once.h"

namespace skyquilt::alignment {
namespace {

constexpr int kLost = 5;

// A flight of eight photos whose poses are all known but that of one.
class RegisterByResectionTest : public testing::Test {
 protected:
  static simulate::SimulatedFlight MakeTruth() {
    simulate::SimulateOptions options;
    options.seed = options.world.seed = 6;
    options.noise = simulate::NoiseClass::kExact;
    options.intrinsics = camera::Intrinsics::Centered(800, 600, 750.0);
    options.trajectory.photos = 8;
    options.trajectory.photos_per_line = 4;
    return *simulate::PlanSimulatedFlight(options);
  }

  void Extract(const simulate::SimulatedFlight& pictures) {
    features_.resize(posed_.photos.size());
    input_ = MakeMatchingInput(posed_);
    for (std::size_t i = 0; i < features_.size(); ++i) {
      const simulate::SimulatedFlight& shown = i == kLost ? pictures : truth_;
      features_[i] = *ExtractFeatures(posed_.photos[i].photo, test::PhotosOf(shown), FeatureOptions{});
      input_.features[i] = &features_[i];
    }
    is_aligned_.assign(features_.size(), 1);
    is_aligned_[kLost] = 0;
  }

  // Puts the lost photo elsewhere.
  void Misplace(double turn_rad, const Eigen::Vector3d& by_m) {
    geo::Rigid3& pose = input_.views[kLost].cam_from_enu;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d(0.05, 0.03, 1.0).normalized()));
    pose = geo::Rigid3::FromRotationAndTargetOrigin(turn * pose.rotation, pose.TargetOriginInSource() + by_m);
  }

  simulate::SimulatedFlight truth_ = MakeTruth();
  poses::PosedFlight posed_ = PosesOf(truth_);
  std::vector<PhotoFeatures> features_;
  MatchingInput input_;
  std::vector<char> is_aligned_;
};

TEST_F(RegisterByResectionTest, FindThePoseThatAllNeighboursAgreeOn) {
  Extract(truth_);
  const geo::Rigid3 truth = input_.views[kLost].cam_from_enu;
  Misplace(70.0 * std::numbers::pi / 180.0, {18.0, -12.0, 4.0});
  const std::vector<ResectedPhoto> found =
      RegisterByResection(input_, Relief(posed_.ground_z_in_enu_m), is_aligned_, 3.0, 2);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].photo, kLost);
  EXPECT_LT((found[0].cam_from_enu.TargetOriginInSource() - truth.TargetOriginInSource()).norm(), 0.5);
  EXPECT_LT(found[0].cam_from_enu.rotation.angularDistance(truth.rotation), 0.01);
  EXPECT_GE(found[0].links.size(), 2u);
}

TEST_F(RegisterByResectionTest, LeaveAPhotoOfAnotherPlace) {
  simulate::SimulatedFlight elsewhere = truth_;
  simulate::WorldOptions other = truth_.options.world;
  other.seed += 1000;
  elsewhere.world = simulate::World(other);
  Extract(elsewhere);
  EXPECT_TRUE(RegisterByResection(input_, Relief(posed_.ground_z_in_enu_m), is_aligned_, 3.0, 2).empty());
}

}  // namespace
}  // namespace skyquilt::alignment
