// Two photos that hold each other but lie metres and degrees off, as a corner of a flight does whose records
// are poor.
#include "core/alignment/from_records/registration_rounds.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/alignment/from_records/bundle_setup.h"
#include "core/alignment/from_records/correct_poses.h"
#include "core/alignment/matching/connected_components.h"
#include "core/alignment/matching/match_and_verify.h"
#include "core/alignment/scene/tracks.h"
#include "tests/core/alignment/simulated_case.h"
#include "tests/support/rendered_once.h"

namespace skyquilt::alignment {
namespace {

constexpr std::size_t kPhotos = 10;
constexpr std::size_t kRest = 8;  // the last two are the component apart

simulate::SimulatedFlight MakeTruth() {
  simulate::SimulateOptions options;
  options.seed = options.world.seed = 6;
  options.noise = simulate::NoiseClass::kExact;
  options.intrinsics = camera::Intrinsics::Centered(800, 600, 750.0);
  options.trajectory.photos = kPhotos;
  options.trajectory.photos_per_line = 5;
  return *simulate::PlanSimulatedFlight(options);
}

TEST(RegisterInRounds, BringsAComponentOfTwoToTheOthers) {
  const simulate::SimulatedFlight truth = MakeTruth();
  const poses::PosedFlight right = PosesOf(truth);
  poses::PosedFlight posed = right;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(12.0 * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ()));
  for (std::size_t i = kRest; i < kPhotos; ++i) {
    geo::Rigid3& pose = posed.photos[i].cam_from_enu;
    pose = geo::Rigid3::FromRotationAndTargetOrigin(
        pose.rotation * turn.conjugate(),
        turn * pose.TargetOriginInSource() + Eigen::Vector3d(9.0, -6.0, 0.0));
  }
  const Relief relief(posed.ground_z_in_enu_m);
  MatchingInput input = MakeMatchingInput(posed);
  std::vector<PhotoFeatures> features(kPhotos);
  for (std::size_t i = 0; i < kPhotos; ++i) {
    features[i] = *ExtractFeatures(posed.photos[i].photo, test::PhotosOf(truth), FeatureOptions{});
    input.features[i] = &features[i];
  }
  std::vector<CandidatePair> pairs;
  for (int i = 0; i < static_cast<int>(kPhotos); ++i) {
    for (int j = i + 1; j < static_cast<int>(kPhotos); ++j) {
      if ((i < static_cast<int>(kRest)) == (j < static_cast<int>(kRest))) pairs.push_back({i, j, 0.5});
    }
  }
  MatchedFlight linked;
  linked.links = MatchAndVerify(input, ProjectAllToGround(input, relief, 2), pairs, MatchingPass{}, 2);
  ASSERT_EQ(FindConnectedComponents(kPhotos, linked.links).members.size(), 2u);
  const std::vector<GroundPrior> recorded = MakeGroundPriors(posed, input);
  for (std::size_t i = 0; i < kPhotos; ++i) {
    linked.corrected.push_back(CorrectPose(posed.photos[i], recorded[i], {}));
  }
  BundleProblem problem = MakeBundle(posed, linked.corrected, std::vector<int>(kPhotos, 0));
  problem.tracks = BuildTracks(linked.links, input.features, input.views, {});

  EXPECT_EQ(RegisterInRounds(posed, relief, 2, input, linked, problem), 2);
  EXPECT_EQ(FindConnectedComponents(kPhotos, linked.links).members.size(), 1u);
  for (std::size_t i = kRest; i < kPhotos; ++i) {
    const geo::Rigid3& want = right.photos[i].cam_from_enu;
    const geo::Rigid3& found = problem.photos[i].cam_from_enu;
    EXPECT_LT((found.TargetOriginInSource() - want.TargetOriginInSource()).norm(), 1.0) << i;
    EXPECT_LT(found.rotation.angularDistance(want.rotation), 0.02) << i;
  }
}

TEST(OnlyWithinComponents, LeavesOutWhatNoVerifiedPairsHoldTogether) {
  const std::vector<VerifiedPair> links = {{0, 1, {}, {}, 0.0}, {1, 2, {}, {}, 0.0}, {3, 4, {}, {}, 0.0}};
  const std::vector<CandidatePair> pairs = {{0, 2, 0.3}, {2, 3, 0.4}, {4, 5, 0.5}};
  const std::vector<CandidatePair> want = {{0, 1, 0.0}, {0, 2, 0.3}, {1, 2, 0.0}, {3, 4, 0.0}};
  EXPECT_EQ(OnlyWithinComponents(pairs, links, 6), want);
}

}  // namespace
}  // namespace skyquilt::alignment
