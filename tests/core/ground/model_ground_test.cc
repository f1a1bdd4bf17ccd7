#include "core/ground/model_ground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace skyquilt::ground {
namespace {

// 60 m over ground of the given shape, points every `spacing_m` with some noise and wild outliers.
template <typename Shape>
alignment::AlignedFlight FlightOver(const Shape& height_at, double noise_m) {
  alignment::AlignedFlight flight;
  alignment::AlignedPhoto photo;
  photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  photo.height_above_ground_m = 60.0;
  const Eigen::Quaterniond looks_down(
      (Eigen::Matrix3d() << 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0).finished());
  for (const Eigen::Vector3d& center : {Eigen::Vector3d(-100.0, -100.0, 60.0),
                                        {100.0, -100.0, 60.0},
                                        {-100.0, 100.0, 60.0},
                                        {100.0, 100.0, 60.0}}) {
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(looks_down, center);
    flight.photos.push_back(photo);
  }
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, noise_m);
  std::uniform_real_distribution<double> place(-100.0, 100.0);
  for (int i = 0; i < 6000; ++i) {
    const double east = place(random);
    const double north = place(random);
    const double z = i % 50 == 0 ? -56.0 : height_at(east, north) + noise(random);
    flight.tie_points_in_enu.emplace_back(east, north, z);
  }
  return flight;
}

TEST(ModelGround, ChoosesThePlaneOnFlatGroundAtTheHeightOfThePoints) {
  ModelGroundReport report;
  const GroundSurface surface = ModelGround(FlightOver([](double, double) { return 2.0; }, 0.05), report);
  EXPECT_TRUE(surface.IsPlane()) << report.reason;
  EXPECT_NEAR(surface.MeanHeight(), 2.0, 0.02);
  EXPECT_EQ(report.model, "plane");
}

TEST(ModelGround, PassesOverPointsThatAreNoNumbers) {
  alignment::AlignedFlight flight = FlightOver([](double, double) { return 2.0; }, 0.05);
  ModelGroundReport clean, report;
  ModelGround(flight, clean);
  const double nan = std::nan("");
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < 50; ++i) {
      flight.tie_points_in_enu.emplace_back(1.0, 1.0, 2.0);
      flight.tie_points_in_enu.back()[axis] = nan;
    }
  }
  EXPECT_NEAR(ModelGround(flight, report).MeanHeight(), 2.0, 0.02);
  EXPECT_EQ(report.points_used, clean.points_used);
}

TEST(ModelGround, FollowsHillsToAFewDecimetresInSpiteOfOutliers) {
  const auto hills = [](double east, double north) {
    return 5.0 * std::sin(east / 30.0) + 3.0 * std::cos(north / 25.0);
  };
  ModelGroundReport report;
  const GroundSurface surface = ModelGround(FlightOver(hills, 0.1), report);
  ASSERT_FALSE(surface.IsPlane()) << report.reason;
  double square = 0.0;
  int count = 0;
  for (double east = -95.0; east <= 95.0; east += 5.0) {
    for (double north = -95.0; north <= 95.0; north += 5.0) {
      const double error = surface.HeightAt({east, north}) - hills(east, north);
      square += error * error;
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(square / count), 0.2);
  EXPECT_GT(report.lowest_m, -12.0) << "an outlier made a pit";
}

TEST(ModelGround, CarriesASlopeOnAsFarAsPhotosSeeAndNoFarther) {
  const auto slope = [](double east, double) { return 0.1 * east; };
  ModelGroundReport report;
  const GroundSurface surface = ModelGround(FlightOver(slope, 0.05), report);
  ASSERT_FALSE(surface.IsPlane());
  for (const double east : {-130.0, -110.0, 110.0, 130.0})
    EXPECT_NEAR(surface.HeightAt({east, 0.0}), 0.1 * east, 0.3);
  // Forty metres beyond the last point the photos see nothing.
  EXPECT_LE(surface.MaxHeight(), 14.5);
  EXPECT_GE(surface.MinHeight(), -14.5);
}

TEST(ModelGround, CarriesOnTheBowlThatALensBendsHeightsTo) {
  const auto bowl = [](double east, double north) { return 1e-4 * (east * east + north * north); };
  ModelGroundReport report;
  const GroundSurface surface = ModelGround(FlightOver(bowl, 0.02), report);
  ASSERT_FALSE(surface.IsPlane());
  for (const Eigen::Vector2d& outside :
       {Eigen::Vector2d(125.0, 0.0), {-120.0, 30.0}, {0.0, 130.0}, {110.0, -110.0}}) {
    EXPECT_NEAR(surface.HeightAt(outside), bowl(outside.x(), outside.y()), 0.15) << outside.transpose();
  }
}

TEST(ModelGround, CarriesTheFlankOfAHillOnForAWhile) {
  const auto hills = [](double east, double) {
    return 6.0 * std::sin(east / 25.0);
  };  // a flank at the end: 100 / 25
  ModelGroundReport report;
  const GroundSurface surface = ModelGround(FlightOver(hills, 0.05), report);
  ASSERT_FALSE(surface.IsPlane());
  double error = 0.0, error_level = 0.0;
  for (double north = -80.0; north <= 80.0; north += 20.0) {
    error += std::abs(surface.HeightAt({110.0, north}) - hills(110.0, north));
    error_level += std::abs(hills(98.0, north) - hills(110.0, north));
  }
  EXPECT_LT(error, 0.7 * error_level);
}

TEST(ModelGround, HousesAtItsEdgeDoNotTiltTheGroundBeyond) {
  const auto street = [](double east, double north) {
    return std::abs(north) > 70.0 && std::fmod(std::abs(east), 30.0) < 12.0 ? 4.0 : 0.0;
  };
  ModelGroundReport report;
  const GroundSurface surface = ModelGround(FlightOver(street, 0.05), report);
  for (double east = -90.0; east <= 90.0; east += 5.0) {
    EXPECT_GT(surface.HeightAt({east, 120.0}), -1.0) << east;
    EXPECT_LT(surface.HeightAt({east, 120.0}), 5.0) << east;
  }
}

TEST(ModelGround, IsTheRecordedGroundWhereTooFewPointsAreKnown) {
  alignment::AlignedFlight flight;
  flight.ground_z_in_enu_m = 4.0;
  flight.tie_points_in_enu = {{0.0, 0.0, 30.0}, {1.0, 0.0, 31.0}};
  ModelGroundReport report;
  const GroundSurface surface = ModelGround(flight, report);
  EXPECT_TRUE(surface.IsPlane());
  EXPECT_EQ(surface.MeanHeight(), 4.0);
}

// Hills, `zero_m` above the flight's z = 0, known from 47.4, 8.5 outwards in enu of that place.
class HillyModel final : public geo::DemSource {
 public:
  HillyModel(double zero_m, double wrong_by) : zero_m_(zero_m), wrong_by_(wrong_by) {}
  static double At(double east, double north) {
    return 6.0 * std::sin(east / 40.0) + 4.0 * std::cos(north / 30.0);
  }
  std::optional<double> GroundHeightM(const geo::LatLon& position) const override {
    const Eigen::Vector3d at = Frame().EnuAtHeight(position, 0.0);
    if (at.x() > 150.0) return std::nullopt;
    return zero_m_ + At(at.x() + wrong_by_, at.y());
  }
  static geo::LocalFrame Frame() { return geo::LocalFrame({47.4, 8.5, 500.0}); }

 private:
  double zero_m_, wrong_by_;
};

// The hills of the model, tie points on the western half alone.
alignment::AlignedFlight HalfTied(double model_too_low_m) {
  alignment::AlignedFlight flight =
      FlightOver([&](double e, double n) { return HillyModel::At(e, n) + model_too_low_m; }, 0.1);
  flight.frame = HillyModel::Frame();
  std::erase_if(flight.tie_points_in_enu, [](const Eigen::Vector3d& point) { return point.x() > 0.0; });
  for (alignment::AlignedPhoto& photo : flight.photos) {
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(photo.cam_from_enu.rotation,
                                                                  Eigen::Vector3d(0.0, 0.0, 60.0));
  }
  return flight;
}

double WorstInTheEast(const GroundSurface& surface, double up_m) {
  double worst = 0.0;
  for (double east = 10.0; east <= 90.0; east += 5.0) {
    worst = std::max(worst, std::abs(surface.HeightAt({east, 20.0}) - HillyModel::At(east, 20.0) - up_m));
  }
  return worst;
}

TEST(ModelGroundOverElevations, MovesTheModelToThePointsAndTrustsItWhereThereAreNone) {
  const alignment::AlignedFlight flight = HalfTied(1.7);
  const HillyModel model(432.0, 0.0);
  ModelGroundReport report, without;
  const GroundSurface surface = ModelGround(flight, report, ElevationModel{&model, 432.0});
  EXPECT_EQ(report.model, "elevation model") << report.reason;
  EXPECT_NEAR(report.dem_shift_m.value(), 1.7, 0.1);
  EXPECT_LT(WorstInTheEast(surface, 1.7), 0.3);
  EXPECT_GT(WorstInTheEast(ModelGround(flight, without), 1.7), 2.0);
}

TEST(ModelGroundOverElevations, LeavesAModelThatContradictsThePoints) {
  const HillyModel model(432.0, 130.0);
  ModelGroundReport report;
  ModelGround(HalfTied(0.0), report, ElevationModel{&model, 432.0});
  EXPECT_EQ(report.model, "grid") << report.reason;
  EXPECT_GT(report.dem_error_m.value(), 0.5 * report.plane_error_m);
  EXPECT_NE(report.reason.find("does not fit"), std::string::npos);
}

TEST(ModelGroundOverElevations, TakesTheModelAsLaidWithoutPoints) {
  alignment::AlignedFlight flight = HalfTied(0.0);
  flight.tie_points_in_enu.clear();
  const HillyModel model(432.0, 0.0);
  ModelGroundReport report;
  const GroundSurface surface = ModelGround(flight, report, ElevationModel{&model, 432.0});
  EXPECT_EQ(report.model, "elevation model") << report.reason;
  EXPECT_LT(WorstInTheEast(surface, 0.0), 0.1);
}

TEST(ModelGroundOverElevations, IgnoresAModelThatLiesElsewhere) {
  alignment::AlignedFlight flight = HalfTied(0.0);
  flight.frame = geo::LocalFrame({47.4, 8.6, 500.0});
  const HillyModel model(432.0, 0.0);
  ModelGroundReport report;
  ModelGround(flight, report, ElevationModel{&model, 432.0});
  EXPECT_NE(report.model, "elevation model");
  EXPECT_FALSE(report.dem_error_m.has_value());
}

}  // namespace
}  // namespace skyquilt::ground
