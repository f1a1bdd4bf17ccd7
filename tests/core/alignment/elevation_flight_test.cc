// Simulated flights over hills with an elevation model of them, from the recorded poses to places on the
// ground.
#include <gtest/gtest.h>

#include "core/alignment/align_by_pose.h"
#include "core/base/median.h"
#include "core/poses/estimate_poses.h"
#include "core/poses/heights/flight_heights.h"
#include "tests/core/alignment/simulated_case.h"

namespace skyquilt::alignment {
namespace {

// The simulated hills, counted from a zero of the model's own.
class HillsOfWorld final : public geo::DemSource {
 public:
  explicit HillsOfWorld(const simulate::SimulatedFlight& truth) : truth_(truth) {}
  std::optional<double> GroundHeightM(const geo::LatLon& position) const override {
    const Eigen::Vector3d at = truth_.frame.EnuAtHeight(position, 0.0);
    return 731.0 + truth_.world.TerrainHeightAt(at.x(), at.y());
  }

 private:
  const simulate::SimulatedFlight& truth_;
};

simulate::SimulatedFlight OverHills(simulate::NoiseClass noise) {
  simulate::SimulateOptions options;
  options.noise = noise;
  options.intrinsics = camera::Intrinsics::Centered(800, 600, 750.0);
  options.trajectory.photos = 8;
  options.trajectory.photos_per_line = 4;
  options.world.relief_m = 12.0;
  return *simulate::PlanSimulatedFlight(options);
}

struct Placed {
  GroundError error;
  std::string model;
};

template <typename Align>
Placed Place(const simulate::SimulatedFlight& truth, const geo::DemSource* dem, const Align& align) {
  flight::Flight flight;
  for (const simulate::SimulatedPhoto& photo : truth.photos) flight.photos.push_back(photo.photo);
  poses::EstimatePosesOptions options;
  options.dem = dem;
  const auto posed = poses::EstimatePoses(flight, options);
  EXPECT_TRUE(posed.ok());
  EXPECT_EQ(posed->dem_zero_m.has_value(), dem != nullptr);
  const AlignedFlight aligned = align(*posed);
  std::optional<ground::ElevationModel> model;
  if (dem != nullptr) model = {dem, *posed->dem_zero_m};
  ground::ModelGroundReport report;
  const ground::GroundSurface surface = ground::ModelGround(aligned, report, model);
  return {MeasureGroundError(truth, aligned, surface), report.model};
}

TEST(FlightOverHills, IsDrapedOverTheElevationModelWithoutAnyTiePoint) {
  const simulate::SimulatedFlight truth = OverHills(simulate::NoiseClass::kExact);
  const HillsOfWorld hills(truth);
  const auto by_pose = [](const poses::PosedFlight& posed) { return AlignByPoseOnly(posed); };
  const Placed flat = Place(truth, nullptr, by_pose);
  const Placed draped = Place(truth, &hills, by_pose);
  RecordProperty("flat_ce90_m", std::to_string(flat.error.relative_ce90_m));
  RecordProperty("draped_ce90_m", std::to_string(draped.error.relative_ce90_m));
  EXPECT_EQ(flat.model, "plane");
  EXPECT_EQ(draped.model, "elevation model");
  EXPECT_GT(flat.error.relative_ce90_m, 1.0);
  // Not all of it goes: where it took off is not recorded, so the ground below the first photo stands for it.
  EXPECT_LT(draped.error.relative_ce90_m, 0.5 * flat.error.relative_ce90_m);
}

TEST(FlightOverHills, MovesTheElevationModelToTheTiePoints) {
  const simulate::SimulatedFlight truth = OverHills(simulate::NoiseClass::kXmpTypical);
  const HillsOfWorld hills(truth);
  const auto by_pictures = [&](const poses::PosedFlight& posed) { return Align(truth, posed).flight; };
  const Placed without = Place(truth, nullptr, by_pictures);
  const Placed with = Place(truth, &hills, by_pictures);
  RecordProperty("without_ce90_m", std::to_string(without.error.relative_ce90_m));
  RecordProperty("with_ce90_m", std::to_string(with.error.relative_ce90_m));
  EXPECT_EQ(with.model, "elevation model");
  EXPECT_LT(with.error.relative_ce90_m, 1.05 * without.error.relative_ce90_m);
}

// How far above the true ones the cameras of a map stand.
double CamerasTooHighM(const simulate::SimulatedFlight& truth) {
  const Outcome outcome = Align(truth, PosesOf(truth));
  EXPECT_EQ(outcome.report.aligned, static_cast<int>(truth.photos.size()));
  std::vector<double> off_m;
  for (std::size_t i = 0; i < outcome.flight.photos.size(); ++i) {
    const auto height_m = [](const geo::LocalFrame& frame, const geo::Rigid3& cam_from_enu) {
      return frame.Wgs84FromEnu(cam_from_enu.TargetOriginInSource()).height_ellipsoid_m;
    };
    off_m.push_back(height_m(outcome.flight.frame, outcome.flight.photos[i].cam_from_enu) -
                    height_m(truth.frame, truth.photos[i].pose.cam_from_enu));
  }
  return Median(std::move(off_m));
}

constexpr double kRecordedHeightsHoldM = 4.0;  // errors of such a receiver, and of the focal length

TEST(HeightOfAMap, IsTheCamerasOwnWhereTheGroundBelowWasGuessed) {
  simulate::SimulateOptions options = SmallTruth(8, 0.0).options;
  options.trajectory.front_overlap = 0.88;  // half as far apart as the guess takes for usual
  simulate::SimulatedFlight truth = *simulate::PlanSimulatedFlight(options);
  for (simulate::SimulatedPhoto& photo : truth.photos) {
    photo.photo.position->height_above_takeoff_m.reset();
    photo.photo.position->height_above_ground_m.reset();
  }
  EXPECT_LT(std::abs(CamerasTooHighM(truth)), kRecordedHeightsHoldM);
}

// Some programs write the height above the sea where that above the take-off belongs.
TEST(HeightOfAMap, IsTheCamerasOwnWhereWhatTheyRecordOfTheGroundIsRefuted) {
  simulate::SimulatedFlight truth = SmallTruth(8, 0.0);
  for (simulate::SimulatedPhoto& photo : truth.photos) {
    flight::RecordedPosition& position = *photo.photo.position;
    position.height_above_takeoff_m = poses::EllipsoidHeightM(position).value();
  }
  EXPECT_GT(*truth.photos.front().photo.position->height_above_takeoff_m, 200.0);
  EXPECT_LT(std::abs(CamerasTooHighM(truth)), kRecordedHeightsHoldM);
}

}  // namespace
}  // namespace skyquilt::alignment
