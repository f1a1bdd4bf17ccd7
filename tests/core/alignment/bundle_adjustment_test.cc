#include "core/alignment/bundle/bundle_adjustment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/alignment/from_records/bundle_setup.h"

namespace skyquilt::alignment {
namespace {

constexpr double kHeightM = 60.0;

// Straight down, the image's top towards north.
geo::Rigid3 Downwards(double east_m, double north_m) {
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
  return geo::Rigid3::FromRotationAndTargetOrigin(rotation, {east_m, north_m, kHeightM});
}

// A point as every photo sees it, without noise.
Track Seen(const std::vector<geo::Rigid3>& truth, const camera::Intrinsics& lens,
           const Eigen::Vector3d& point_in_enu) {
  Track track;
  track.point_in_enu = point_in_enu;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector3d in_cam = truth[i] * point_in_enu;
    const Eigen::Vector2d bent = lens.Distort(in_cam.head<2>() / in_cam.z());
    track.observations.push_back(
        {static_cast<int>(i),
         {lens.focal_x_px * bent.x() + lens.center_x_px, lens.focal_y_px * bent.y() + lens.center_y_px},
         1.0});
  }
  return track;
}

// Four photos over hilly ground; poses, points and priors start at the truth.
struct Scene {
  std::vector<geo::Rigid3> truth{Downwards(0, 0), Downwards(12, 0), Downwards(0, 12), Downwards(12, 12)};
  BundleProblem problem;

  Scene() {
    BundleLens lens;
    lens.recorded = lens.intrinsics = camera::Intrinsics::Centered(2000, 1500, 1400.0);
    problem.lenses.push_back(lens);
    for (const geo::Rigid3& pose : truth) {
      BundlePhoto photo;
      photo.cam_from_enu = photo.prior_cam_from_enu = pose;
      photo.sigma_position_m = Eigen::Vector3d::Constant(0.5);
      photo.height_above_ground_m = kHeightM;
      problem.photos.push_back(photo);
    }
    for (int east = -18; east <= 30; east += 6) {
      for (int north = -12; north <= 24; north += 6) {
        problem.tracks.push_back(
            Seen(truth, lens.recorded, {1.0 * east, 1.0 * north, 3.0 * std::sin(0.2 * east + 0.1 * north)}));
      }
    }
  }
  void Displace(std::size_t photo) {
    geo::Rigid3& pose = problem.photos[photo].cam_from_enu;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.02, Eigen::Vector3d(0.3, 0.2, 1.0).normalized()));
    pose = geo::Rigid3::FromRotationAndTargetOrigin(
        turn * pose.rotation, pose.TargetOriginInSource() + Eigen::Vector3d(0.6, -0.4, 0.5));
  }
  double FarOffM(std::size_t photo) const {
    return (problem.photos[photo].cam_from_enu.TargetOriginInSource() - truth[photo].TargetOriginInSource())
        .norm();
  }
};

// Above the cameras, so behind all of them: no residual can be computed.
Track BehindAllCameras() {
  Track track;
  track.point_in_enu = {5.0, 5.0, kHeightM + 40.0};
  for (int i = 0; i < 4; ++i) track.observations.push_back({i, {1000.0, 700.0}, 1.0});
  return track;
}

TEST(AdjustBundle, BringsADisplacedPhotoBack) {
  Scene scene;
  scene.Displace(3);
  const BundleSummary summary = AdjustBundle(scene.problem, {.cuts_px = {400.0, 20.0}});
  EXPECT_FALSE(summary.has_failed);
  EXPECT_EQ(summary.solver, "dense_schur");
  EXPECT_EQ(summary.dropped, 0);
  EXPECT_EQ(summary.observations, 4 * 63);
  EXPECT_LT(summary.rms_px, 0.1);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT(scene.FarOffM(i), 0.05) << i;
}

TEST(AdjustBundle, DropsAWrongObservationAndKeepsItsPoint) {
  Scene scene;
  Observation& wrong = scene.problem.tracks[20].observations[1];
  wrong.pixel_in_image += Eigen::Vector2d(120.0, -80.0);
  const BundleSummary summary = AdjustBundle(scene.problem, {.cuts_px = {20.0, 6.0}});
  EXPECT_EQ(summary.dropped, 1);
  EXPECT_EQ(scene.problem.tracks.size(), 63u);
  EXPECT_EQ(scene.problem.tracks[20].observations.size(), 3u);
  EXPECT_LT(summary.rms_px, 0.1);
}

TEST(AdjustBundle, LeavesFixedPhotosWhereTheyAre) {
  Scene scene;
  for (const std::size_t i : {0, 1, 2}) scene.problem.photos[i].is_fixed = true;
  scene.problem.lenses[0].is_fixed = true;
  scene.Displace(3);
  AdjustBundle(scene.problem, {.cuts_px = {400.0, 20.0}});
  for (const std::size_t i : {0, 1, 2}) EXPECT_LT(scene.FarOffM(i), 1e-9) << i;
  EXPECT_LT(scene.FarOffM(3), 0.05);
}

TEST(AdjustBundle, KeepsTheStateWhereNoSolutionIsUsable) {
  Scene scene;
  scene.Displace(3);
  scene.problem.tracks.push_back(BehindAllCameras());
  const BundleProblem before = scene.problem;
  const BundleSummary summary = AdjustBundle(scene.problem, {.cuts_px = {400.0}});
  EXPECT_TRUE(summary.has_failed);
  EXPECT_NE(summary.solver.find("failed: "), std::string::npos) << summary.solver;
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(scene.problem.photos[i].cam_from_enu.translation, before.photos[i].cam_from_enu.translation);
    EXPECT_EQ(scene.problem.photos[i].cam_from_enu.rotation.coeffs(),
              before.photos[i].cam_from_enu.rotation.coeffs());
  }
  EXPECT_EQ(scene.problem.lenses[0].intrinsics.focal_x_px, before.lenses[0].intrinsics.focal_x_px);
}

TEST(AdjustBundle, GoesOnOnceThePointThatFailedIsDropped) {
  Scene scene;
  scene.Displace(3);
  scene.problem.tracks.push_back(BehindAllCameras());
  const BundleSummary summary = AdjustBundle(scene.problem, {.cuts_px = {400.0, 400.0, 20.0}});
  EXPECT_FALSE(summary.has_failed);
  EXPECT_EQ(summary.solver, "dense_schur");
  EXPECT_EQ(scene.problem.tracks.size(), 63u);
  EXPECT_LT(scene.FarOffM(3), 0.05);
}

TEST(AdjustBundle, DropsATieOfWholePicturesThatLiesBehindACamera) {
  Scene scene;
  scene.Displace(3);
  scene.problem.soft_tracks = {Seen(scene.truth, scene.problem.lenses[0].recorded, {6.0, 6.0, 0.0}),
                               BehindAllCameras()};
  const BundleSummary summary = AdjustBundle(scene.problem, {.cuts_px = {400.0, 20.0}});
  EXPECT_FALSE(summary.has_failed) << summary.solver;
  EXPECT_EQ(scene.problem.soft_tracks.size(), 1u);
  EXPECT_LT(scene.FarOffM(3), 0.05);
}

// Looked up on a track `early_s` too early: two photos eastwards, two back or eastwards too.
void LookUpEarly(double early_s, bool is_to_and_fro, Scene& scene) {
  constexpr double kSpeedMps = 2.0;
  scene.problem.sigma_clock_s = 2.0;
  for (std::size_t i = 0; i < 4; ++i) {
    BundlePhoto& photo = scene.problem.photos[i];
    photo.by_clock_mps = Eigen::Vector3d(i >= 2 && is_to_and_fro ? -kSpeedMps : kSpeedMps, 0.0, 0.0);
    photo.prior_cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
        scene.truth[i].rotation, scene.truth[i].TargetOriginInSource() - early_s * photo.by_clock_mps);
  }
}

TEST(AdjustBundle, FindsTheErrorOfAClockThatPhotosShare) {
  for (const double early_s : {0.4, -0.5}) {
    Scene scene;
    LookUpEarly(early_s, true, scene);
    AdjustBundle(scene.problem, {.cuts_px = {20.0, 6.0}});
    EXPECT_NEAR(scene.problem.clock_error_s, early_s, 0.03);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_LT(scene.FarOffM(i), 0.1) << i;
      EXPECT_LT(
          (ExpectedCenter(scene.problem, scene.problem.photos[i]) - scene.truth[i].TargetOriginInSource())
              .norm(),
          0.1)
          << i;
    }
  }
}

TEST(AdjustBundle, LeavesAClockThatNothingShowsToBeWrong) {
  Scene right;
  LookUpEarly(0.0, true, right);
  AdjustBundle(right.problem, {.cuts_px = {20.0, 6.0}});
  EXPECT_NEAR(right.problem.clock_error_s, 0.0, 0.01);

  Scene one_course;  // a shift of all alike
  LookUpEarly(0.4, false, one_course);
  AdjustBundle(one_course.problem, {.cuts_px = {20.0, 6.0}});
  EXPECT_NEAR(one_course.problem.clock_error_s, 0.0, 0.05);

  Scene by_events;  // no clock in doubt
  LookUpEarly(0.4, true, by_events);
  by_events.problem.sigma_clock_s = 0.0;
  AdjustBundle(by_events.problem, {.cuts_px = {20.0, 6.0}});
  EXPECT_EQ(by_events.problem.clock_error_s, 0.0);
}

TEST(MakeBundlePhoto, HoldsPhotosOfALogApartFromTheirClock) {
  poses::PosedPhoto posed;
  posed.cam_from_enu = Downwards(0, 0);
  posed.covariance.setIdentity();
  posed.covariance(3, 3) += 100.0;  // 2 s at 5 m/s
  posed.velocity_in_enu_mps = Eigen::Vector3d(5.0, 0.0, 0.0);
  PhotoFindings corrected;
  corrected.start_cam_from_enu = corrected.prior_cam_from_enu = posed.cam_from_enu;

  BundlePhoto photo = MakeBundlePhoto(posed, corrected, 0, 0);
  EXPECT_NEAR(photo.sigma_position_m.x(), std::sqrt(51.0), 1e-9) << "nothing is said of a clock";
  EXPECT_TRUE(photo.by_clock_mps.isZero());

  posed.clock_sigma_s = 2.0;
  photo = MakeBundlePhoto(posed, corrected, 0, 0);
  EXPECT_NEAR(photo.sigma_position_m.x(), 1.0, 1e-9);
  EXPECT_NEAR(photo.sigma_position_m.z(), 1.0, 1e-9);
  EXPECT_EQ(photo.by_clock_mps, *posed.velocity_in_enu_mps);

  posed.covariance(3, 3) = 90.0;  // less than the clock alone would make it
  EXPECT_GT(MakeBundlePhoto(posed, corrected, 0, 0).sigma_position_m.x(), 0.5)
      << "nobody flies that straight";

  posed.covariance(3, 3) = 101.0;
  corrected.position_was_wrong = true;
  EXPECT_TRUE(MakeBundlePhoto(posed, corrected, 0, 0).by_clock_mps.isZero());
}

TEST(AdjustBundle, TakesAProblemWithoutObservations) {
  Scene scene;
  scene.problem.tracks.clear();
  const BundleSummary summary = AdjustBundle(scene.problem, {});
  EXPECT_EQ(summary.observations, 0);
  EXPECT_EQ(summary.rms_px, 0.0);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT(scene.FarOffM(i), 1e-9);
}

}  // namespace
}  // namespace skyquilt::alignment
