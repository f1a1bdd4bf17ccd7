// Ties by comparing pictures as a whole, alone: they must bring photos together that their poses leave apart.
#include "core/alignment/from_records/direct_registration.h"

#include <gtest/gtest.h>

#include "core/alignment/align_by_pose.h"
#include "core/alignment/features/features.h"
#include "core/alignment/from_records/bundle_setup.h"
#include "tests/core/alignment/simulated_case.h"

namespace skyquilt::alignment {
namespace {

double ErrorM(const simulate::SimulatedFlight& truth, const AlignedFlight& flight) {
  return MeasureGroundError(truth, flight, ground::GroundSurface::Plane(flight.ground_z_in_enu_m))
      .relative_ce90_m;
}

TEST(DirectTracks, MovePhotosTogetherThatPosesLeaveApart) {
  const simulate::SimulatedFlight truth = SmallTruth(8, 0.0);
  const poses::PosedFlight posed = PosesOf(truth);
  SilentProgress progress;
  const std::vector<PhotoFeatures> features = ExtractAll(posed, test::PhotosOf(truth), {}, 2, 1.0, progress);
  MatchedFlight input = MakeMatchedFlight(posed);
  for (std::size_t i = 0; i < features.size(); ++i) input.features[i] = &features[i];
  std::vector<PhotoFindings> as_recorded;
  for (const poses::PosedPhoto& photo : posed.photos) {
    PhotoFindings& uncorrected = as_recorded.emplace_back();
    uncorrected.start_cam_from_enu = uncorrected.prior_cam_from_enu = photo.cam_from_enu;
  }
  const Relief flat(posed.ground_z_in_enu_m);
  BundleProblem problem = MakeBundle(posed, as_recorded, FindLines(EastNorthOf(posed.photos)));
  for (int pass = 0; pass < 2; ++pass) {  // the second from where the first put them
    input.pairs = SelectPairs(input.views, input.ground_sigma_m, flat);
    problem.soft_tracks = DirectTracks(input, flat, 2);
    AdjustBundle(problem, {.cuts_px = {0.0}, .adjust_lens = false});
    input.views = ViewsOf(problem);
  }

  const AlignedFlight recorded = AlignByPoseOnly(posed);
  AlignedFlight moved = recorded;
  int tied = 0;
  const std::vector<int> support = CountTies(input.views, problem.soft_tracks);
  for (std::size_t i = 0; i < moved.photos.size(); ++i) {
    moved.photos[i].cam_from_enu = problem.photos[i].cam_from_enu;
    tied += support[i] > 0;
  }
  EXPECT_GT(tied, 5);
  EXPECT_LT(ErrorM(truth, moved), 0.7 * ErrorM(truth, recorded));
}

}  // namespace
}  // namespace skyquilt::alignment
