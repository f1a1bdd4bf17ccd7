// Simulated flights over hills with an elevation model of them, from the recorded poses to places on the
// ground.
#include <gtest/gtest.h>

#include "core/alignment/baselines/align_by_pose.h"
#include "core/ground/model_ground.h"
#include "core/poses/estimate_poses.h"
#include "tests/core/alignment/simulated_case.h"
#include "tests/support/rendered_once.h"

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
  const auto by_pictures = [&](const poses::PosedFlight& posed) {
    AlignReport report;
    SilentProgress progress;
    const auto aligned = AlignFlight(posed, test::PhotosOf(truth), {}, report, progress);
    EXPECT_TRUE(aligned.ok());
    return *aligned;
  };
  const Placed without = Place(truth, nullptr, by_pictures);
  const Placed with = Place(truth, &hills, by_pictures);
  RecordProperty("without_ce90_m", std::to_string(without.error.relative_ce90_m));
  RecordProperty("with_ce90_m", std::to_string(with.error.relative_ce90_m));
  EXPECT_EQ(with.model, "elevation model");
  EXPECT_LT(with.error.relative_ce90_m, 1.05 * without.error.relative_ce90_m);
}

}  // namespace
}  // namespace skyquilt::alignment
