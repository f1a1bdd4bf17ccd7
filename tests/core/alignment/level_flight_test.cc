// Flights that wrong heights hold tilted against what a gimbal says.
#include "core/alignment/from_records/level_flight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/flight/remarks/remark_words.h"
#include "tests/core/alignment/simulated_case.h"

namespace skyquilt::alignment {
namespace {

constexpr double kFlownHeightM = 60.0;

geo::Rigid3 Downwards(const Eigen::Vector3d& center) {
  return geo::Rigid3::FromRotationAndTargetOrigin(
      Eigen::Quaterniond(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX())), center);
}

// Three lines of four photos, level and right by their angles; the last half's heights count from `step_m`
// lower; the adjusted state lies tilted about the north by `tilt_rad`.
struct TiltedFlight {
  BundleProblem problem;
  std::vector<PhotoRecord> records;

  explicit TiltedFlight(double tilt_rad, double step_m = 0.0) {
    const Eigen::Quaterniond tilted(Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitY()));
    for (int i = 0; i < 12; ++i) {
      const Eigen::Vector3d center(30.0 * (i / 4), 15.0 * (i % 4), kFlownHeightM);
      PhotoRecord record;
      record.center_in_enu = center + Eigen::Vector3d(0.0, 0.0, i < 6 ? 0.0 : step_m);
      record.sigma_m = {1.5, 1.5, 2.0};
      record.cam_from_enu = Downwards(center).rotation;
      record.sigma_tilt_rad = 0.017;
      records.push_back(record);
      BundlePhoto photo;
      photo.prior_cam_from_enu =
          geo::Rigid3::FromRotationAndTargetOrigin(*record.cam_from_enu, *record.center_in_enu);
      photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
          (*record.cam_from_enu * tilted.conjugate()).normalized(), tilted * center);
      problem.photos.push_back(photo);
      Track track;
      track.observations = {{i, {0.0, 0.0}, 1.0}, {(i + 1) % 12, {0.0, 0.0}, 1.0}};
      track.point_in_enu = tilted * Eigen::Vector3d(center.x(), center.y(), 0.0);
      problem.tracks.push_back(track);
    }
  }
};

TEST(FindLevelling, LeavesWhatLiesAsItsAnglesSay) {
  for (const double tilt : {0.0, 0.02, -0.035}) {
    const TiltedFlight flown(tilt);
    EXPECT_FALSE(FindLevelling(flown.problem, flown.records)) << tilt;
  }
  EXPECT_FALSE(FindLevelling({}, {}));
}

TEST(FindLevelling, LaysATiltedFlightLevel) {
  TiltedFlight flown(-0.2, 15.0);
  const auto levelling = test::ValueOf(FindLevelling(flown.problem, flown.records));
  EXPECT_NEAR(levelling.tilt_rad, 0.2, 1e-9);
  EXPECT_NEAR(levelling.height_range_m, 15.0, 1.0);
  Level(levelling, flown.records, flown.problem);
  double first_z = flown.problem.photos[0].cam_from_enu.TargetOriginInSource().z();
  for (int i = 0; i < 12; ++i) {
    const BundlePhoto& photo = flown.problem.photos[static_cast<std::size_t>(i)];
    EXPECT_LT(
        photo.cam_from_enu.rotation.angularDistance(*flown.records[static_cast<std::size_t>(i)].cam_from_enu),
        1e-9);
    EXPECT_NEAR(photo.cam_from_enu.TargetOriginInSource().z(), first_z, 1e-9);
    EXPECT_NEAR(photo.prior_cam_from_enu.TargetOriginInSource().z(), first_z, 1e-9)
        << "the step is taken out of the records";
    EXPECT_NEAR(flown.problem.tracks[static_cast<std::size_t>(i)].point_in_enu.z(), first_z - kFlownHeightM,
                1e-9);
  }
}

TEST(FindLevelling, BelievesNoAnglesThatAreFewOrRoughOrOfTwoMinds) {
  TiltedFlight rough(0.2), few(0.2), two_minds(0.2), rtk(0.2), nowhere(0.2);
  for (std::size_t i = 0; i < 12; ++i) {
    rough.records[i].sigma_tilt_rad = 0.035;  // an airframe's
    if (i % 3 != 0) few.records[i].cam_from_enu.reset();
    if (i % 2 == 0) {  // as of a mount that leans forward, flown to and fro
      two_minds.records[i].cam_from_enu =
          *two_minds.records[i].cam_from_enu *
          Eigen::Quaterniond(Eigen::AngleAxisd(-0.4, Eigen::Vector3d::UnitY()));
    }
    rtk.records[i].sigma_m.z() = 0.05;
    nowhere.records[i].sigma_m.z() = std::numeric_limits<double>::infinity();
  }
  for (const TiltedFlight* flown : {&rough, &few, &two_minds, &rtk, &nowhere})
    EXPECT_FALSE(FindLevelling(flown->problem, flown->records));
  ASSERT_TRUE(FindLevelling(TiltedFlight(0.2).problem, TiltedFlight(0.2).records));
}

TEST(Level, TurnsWhatWasExpectedOfPhotosThatTheImagesPlaced) {
  TiltedFlight flown(0.2);
  for (BundlePhoto& photo : flown.problem.photos) {
    photo.prior_cam_from_enu = photo.cam_from_enu;
    photo.has_record = false;
  }
  const auto levelling = test::ValueOf(FindLevelling(flown.problem, flown.records));
  for (BundlePhoto& photo : flown.problem.photos) photo.is_by_images = true;
  Level(levelling, flown.records, flown.problem);
  for (const BundlePhoto& photo : flown.problem.photos) {
    EXPECT_LT(
        (photo.prior_cam_from_enu.TargetOriginInSource() - photo.cam_from_enu.TargetOriginInSource()).norm(),
        1e-9);
    EXPECT_LT(photo.prior_cam_from_enu.rotation.angularDistance(photo.cam_from_enu.rotation), 1e-9);
  }
}

TEST(AlignFlight, IsNotTiltedByASecondTakeOffFromLowerGround) {
  const simulate::SimulatedFlight truth = SmallTruth(16, 2.0);
  poses::PosedFlight posed = PosesOf(truth);
  for (std::size_t i = 8; i < 16; ++i) {
    geo::Rigid3& pose = posed.photos[i].cam_from_enu;
    pose = geo::Rigid3::FromRotationAndTargetOrigin(
        pose.rotation, pose.TargetOriginInSource() + Eigen::Vector3d(0.0, 0.0, 15.0));
    posed.photos[i].height_above_ground_m += 15.0;
  }
  const auto [aligned, report, error] = Align(truth, posed);
  EXPECT_EQ(report.aligned, 16);
  ASSERT_FALSE(report.corrections.empty());
  EXPECT_NE(InWords(report.corrections.front()).find("second take-off"), std::string::npos)
      << InWords(report.corrections.front());
  EXPECT_LT(error.absolute_ce90_m, 4.0);
  EXPECT_LT(error.relative_ce90_m, 2.0 * truth.GsdM());
}

}  // namespace
}  // namespace skyquilt::alignment
