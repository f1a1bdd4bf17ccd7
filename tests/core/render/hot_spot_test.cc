#include "core/render/exposure/hot_spot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "core/simulate/world/render_photo.h"
#include "tests/support/simulated_map.h"

namespace skyquilt::render {
namespace {

constexpr std::size_t kGreen = 1;
const Eigen::Vector2d kOpposite{0.045, 0.30};
// The disc that is compared with the ring around it: 3 and 8 m from 66 m above, as a tangent.
constexpr double kDisc = 0.045, kRing = 0.12;

struct SyntheticFlight {
  LightTerms terms;
  std::vector<ExposureSample> samples;
  SpotsOnGround spots;
};

// 40 photos in lines flown to and fro, 66 m high; `brighter`: by the ground and by how far a look is from the
// one opposite the sun. With dark corners, a gain each and noise of 3 %.
SyntheticFlight FlyOver(const std::function<double(const Eigen::Vector2d& ground_m, double away)>& brighter,
                        std::uint32_t seed) {
  constexpr std::uint32_t kPhotos = 40, kPerLine = 8;
  constexpr double kAboveM = 66.0, kStepM = 3.1, kHalfWidth = 0.65, kHalfHeight = 0.49;
  SyntheticFlight flight;
  flight.terms.camera_of_photo.assign(kPhotos, 0);
  flight.terms.cameras = {"a camera"};
  flight.terms.exposure_of_photo.assign(kPhotos, 0.0);
  flight.terms.directions.widest_look = 0.8;
  std::map<std::pair<int, int>, std::vector<ExposureSample>> spots;
  for (std::uint32_t photo = 0; photo < kPhotos; ++photo) {
    const std::uint32_t line = photo / kPerLine;
    const auto chance = [&](int which) {
      return static_cast<double>(simulate::SensorNoise(static_cast<int>(photo), which, 0, seed));
    };
    const Eigen::Vector2d foot{kAboveM * 0.3 * (photo % kPerLine) + 2.0 * chance(1),
                               kAboveM * 0.4 * line + 2.0 * chance(2)};
    const double yaw = (line % 2 == 0 ? 0.5 : -0.5) * std::numbers::pi + 0.1 * chance(3);
    const Eigen::Vector2d lean{0.05 * chance(4), 0.05 * chance(5)};
    const double gain = 0.05 * chance(6);
    flight.spots.middles_m.push_back(foot + kAboveM * kOpposite);
    flight.spots.reach_m = 0.6 * kAboveM;
    const auto cell_of = [&](double at_m) { return static_cast<int>(std::floor(at_m / kStepM)); };
    const int reach = cell_of(kAboveM);
    for (int row = cell_of(foot.y()) - reach; row <= cell_of(foot.y()) + reach; ++row) {
      for (int column = cell_of(foot.x()) - reach; column <= cell_of(foot.x()) + reach; ++column) {
        const Eigen::Vector2d look = (kStepM * Eigen::Vector2d(column, row) - foot) / kAboveM;
        const Eigen::Vector2d in_photo = Eigen::Rotation2Dd(yaw) * (look - lean);
        if (std::abs(in_photo.x()) > kHalfWidth || std::abs(in_photo.y()) > kHalfHeight) continue;
        const Eigen::Vector2d place = in_photo / std::hypot(kHalfWidth, kHalfHeight);
        const double log =
            4.5 + gain - 0.2 * place.squaredNorm() + 0.1 * look.x() +
            brighter(kStepM * Eigen::Vector2d(column, row), (look - kOpposite).norm()) +
            0.03 * static_cast<double>(simulate::SensorNoise(column, row, static_cast<int>(photo), seed + 1));
        ExposureSample sample;
        sample.photo = photo;
        sample.ground_m = {static_cast<float>(kStepM * column), static_cast<float>(kStepM * row)};
        sample.place = {static_cast<float>(place.x()), static_cast<float>(place.y())};
        sample.look = {static_cast<float>(look.x()), static_cast<float>(look.y())};
        sample.log_value.fill(static_cast<float>(log));
        spots[{row, column}].push_back(sample);
      }
    }
  }
  std::uint32_t number = 0;
  for (auto& [cell, seen] : spots) {
    if (seen.size() < 2) continue;
    for (ExposureSample& sample : seen) {
      sample.spot = number;
      flight.samples.push_back(sample);
    }
    ++number;
  }
  return flight;
}

// The mean over the disc around the point opposite the sun less that over the ring.
double AgainstRing(const std::function<double(const Eigen::Vector2d& look)>& light) {
  double disc = 0.0, ring = 0.0;
  int in_disc = 0;
  constexpr int kSteps = 4, kOnRing = 36;
  for (int y = -kSteps; y <= kSteps; ++y) {
    for (int x = -kSteps; x <= kSteps; ++x) {
      if (x * x + y * y > kSteps * kSteps) continue;
      disc += light(kOpposite + kDisc / kSteps * Eigen::Vector2d(x, y));
      ++in_disc;
    }
  }
  for (int k = 0; k < kOnRing; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kOnRing;
    ring += light(kOpposite + kRing * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return disc / in_disc - ring / kOnRing;
}

double OfCusp(double strength, double width, double away) {
  return std::log1p(strength / (1.0 + away / width));
}

// What is taken out of the photos by direction.
double Taken(const LightTerms& terms, const SolvedLight& light, const Eigen::Vector2d& look) {
  const DirectionTerms basis = terms.directions.Basis(look);
  return light.terms.head<kDirectionTerms>().dot(
      Eigen::Map<const Eigen::VectorXd>(basis.data(), basis.size()));
}

void FindIn(SyntheticFlight& flight) {
  const SolvedLight smooth = SolveLight(flight.samples, kGreen, flight.terms);
  flight.terms.directions.hot_spot =
      FindHotSpot(flight.samples, MisfitsOf(flight.samples, kGreen, flight.terms, smooth),
                  flight.terms.directions.widest_look);
}

TEST(HotSpot, IsTakenOutAsHighAndAsWideAsItIs) {
  for (const double width : {0.05, 0.1, 0.2}) {
    for (const double strength : {0.1, 0.2, 0.4}) {
      SCOPED_TRACE(testing::Message() << "strength " << strength << ", width " << width);
      SyntheticFlight flight =
          FlyOver([&](const Eigen::Vector2d&, double away) { return OfCusp(strength, width, away); }, 7);
      FindIn(flight);
      const double is = AgainstRing(
          [&](const Eigen::Vector2d& look) { return OfCusp(strength, width, (look - kOpposite).norm()); });
      ASSERT_TRUE(flight.terms.directions.hot_spot.has_value());
      EXPECT_LT((*flight.terms.directions.hot_spot - kOpposite).norm(), 0.05);
      SolvedLight light = SolveLight(flight.samples, kGreen, flight.terms);
      SettleHotSpot(flight.samples, kGreen, flight.terms, flight.spots, light);
      const double taken =
          AgainstRing([&](const Eigen::Vector2d& look) { return Taken(flight.terms, light, look); });
      EXPECT_NEAR(taken, is, 0.02);
    }
  }
}

TEST(HotSpot, IsNotFoundWhereThereIsNone) {
  for (const std::uint32_t seed : {1u, 20u, 300u, 4000u}) {
    SyntheticFlight flight = FlyOver([](const Eigen::Vector2d&, double) { return 0.0; }, seed);
    FindIn(flight);
    EXPECT_FALSE(flight.terms.directions.hot_spot.has_value()) << seed;
  }
}

TEST(HotSpot, IsTakenBackWhereOverlapsDoNotShowIt) {
  for (const std::uint32_t seed : {1u, 20u, 300u, 4000u}) {
    SyntheticFlight flight = FlyOver([](const Eigen::Vector2d&, double) { return 0.0; }, seed);
    flight.terms.directions.hot_spot = kOpposite;
    SolvedLight light = SolveLight(flight.samples, kGreen, flight.terms);
    SettleHotSpot(flight.samples, kGreen, flight.terms, flight.spots, light);
    const double taken =
        AgainstRing([&](const Eigen::Vector2d& look) { return Taken(flight.terms, light, look); });
    EXPECT_NEAR(taken, 0.0, 0.01) << seed;
  }
}

// The aircraft's shade, or a wet field: a dark spot is none of the sun's.
TEST(HotSpot, IsNeverDark) {
  SyntheticFlight flight =
      FlyOver([](const Eigen::Vector2d&, double away) { return -0.1 * SpotHill(away * away, 0.2); }, 7);
  flight.terms.directions.hot_spot = kOpposite;
  SolvedLight light = SolveLight(flight.samples, kGreen, flight.terms);
  SettleHotSpot(flight.samples, kGreen, flight.terms, flight.spots, light);
  EXPECT_TRUE(light.terms.segment<kSpotTerms>(kSmoothDirectionTerms).isZero(0.0));
}

// Bare soil in the west and grass in the east.
TEST(HotSpot, DiffersWhereTheGroundDoes) {
  constexpr double kEdgeM = 100.0, kClearOfEdgeM = 25.0;
  const auto shares_of = [](double west, double east, std::vector<Eigen::Vector2d>& middles_m) {
    SyntheticFlight flight = FlyOver(
        [&](const Eigen::Vector2d& ground_m, double away) {
          return (ground_m.x() < kEdgeM ? west : east) * 0.2 * SpotHill(away * away, 0.25);
        },
        7);
    middles_m = flight.spots.middles_m;
    flight.terms.directions.hot_spot = kOpposite;
    SolvedLight light = SolveLight(flight.samples, kGreen, flight.terms);
    return SettleHotSpot(flight.samples, kGreen, flight.terms, flight.spots, light);
  };
  std::vector<Eigen::Vector2d> middles_m;
  const std::vector<double> different = shares_of(0.4, 1.3, middles_m);
  std::vector<double> west, east;
  for (std::size_t photo = 0; photo < different.size(); ++photo) {
    if (middles_m[photo].x() < kEdgeM - kClearOfEdgeM) west.push_back(different[photo]);
    if (middles_m[photo].x() > kEdgeM + kClearOfEdgeM) east.push_back(different[photo]);
  }
  ASSERT_GE(west.size(), 10U);
  ASSERT_GE(east.size(), 5U);
  const auto mean = [](const std::vector<double>& of) {
    return std::accumulate(of.begin(), of.end(), 0.0) / static_cast<double>(of.size());
  };
  EXPECT_LT(mean(west), 0.6 * mean(east));
  for (const double share : shares_of(1.0, 1.0, middles_m)) EXPECT_NEAR(share, 1.0, 0.25);
}

// Light that the equations cannot be solved for has no hot spot.
TEST(HotSpot, OfLightWithoutASolutionIsNone) {
  LightTerms terms;
  terms.camera_of_photo = {0, 0};
  terms.cameras = {"a camera"};
  terms.exposure_of_photo = {0.0, 0.0};
  terms.directions = {kOpposite, 0.8};
  const SpotsOnGround spots{{Eigen::Vector2d::Zero(), Eigen::Vector2d::Ones()}, 1.0};
  SolvedLight light{
      Eigen::VectorXd::Zero(2), Eigen::VectorXd::Ones(static_cast<Eigen::Index>(terms.count())), {}, {}};
  EXPECT_EQ(SettleHotSpot({}, kGreen, terms, spots, light), (std::vector<double>{1.0, 1.0}));
  EXPECT_TRUE(light.terms.segment<kSpotTerms>(kSmoothDirectionTerms).isZero(0.0));
}

// What a photo looks like at its point opposite the sun once it is evened, against the ring of 8 m around it;
// its content left out.
std::vector<double> EvenedAgainstRing(const simulate::SimulateOptions& options,
                                      const test::SimulatedMap& map) {
  const Eigen::Vector3d sun = simulate::SunDirection(options.origin, options.start);
  std::vector<double> off;
  for (std::size_t i = 0; i < map.flight.photos.size(); ++i) {
    const alignment::AlignedPhoto& photo = map.flight.photos[i];
    const double height_m = photo.cam_from_enu.TargetOriginInSource().z();
    bool is_inside = true;
    const auto shown = [&](const Eigen::Vector2d& from_middle_m) {
      const Eigen::Vector2d look = -sun.head<2>() / sun.z() + from_middle_m / height_m;
      const Eigen::Vector3d ray{look.x(), look.y(), -1.0};
      const auto pixel = photo.intrinsics.Project(photo.cam_from_enu.rotation * ray);
      is_inside = is_inside && pixel && photo.intrinsics.IsInImage(*pixel);
      if (!is_inside) return 0.0;
      const Eigen::Vector2d center{photo.intrinsics.center_x_px, photo.intrinsics.center_y_px};
      const Eigen::Vector2d place =
          2.0 * (*pixel - center) / std::hypot(photo.intrinsics.width_px, photo.intrinsics.height_px);
      const double phase_rad = std::acos(std::clamp(-ray.normalized().dot(sun), -1.0, 1.0));
      return std::log((1.0 - options.vignetting * place.squaredNorm()) *
                      (1.0 + options.hot_spot / (1.0 + phase_rad / options.hot_spot_rad)) *
                      map.exposure.tones[i].shade.At(place.x(), place.y())[kGreen]);
    };
    double disc = 0.0, ring = 0.0;
    int in_disc = 0;
    for (int y = -3; y <= 3; ++y) {
      for (int x = -3; x <= 3; ++x) {
        if (x * x + y * y > 9) continue;
        disc += shown({x, y});
        ++in_disc;
      }
    }
    constexpr int kOnRing = 24;
    for (int k = 0; k < kOnRing; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kOnRing;
      ring += shown(8.0 * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    if (is_inside) off.push_back(disc / in_disc - ring / kOnRing);
  }
  return off;
}

TEST(HotSpot, LeavesAMapAsLightAtItsPlaceAsAroundIt) {
  for (const auto& [strength, width_rad] :
       {std::pair{0.0, 0.1}, {0.1, 0.05}, {0.2, 0.1}, {0.3, 0.2}, {0.3, 0.05}}) {
    SCOPED_TRACE(testing::Message() << "strength " << strength << ", width " << width_rad);
    simulate::SimulateOptions options = test::SmallPhotos(24);
    options.origin = {40.0, 30.0};  // noon: the point lies well inside the photos
    options.vignetting = 0.2;
    options.exposure_jitter = 0.05;
    options.hot_spot = strength;
    options.hot_spot_rad = width_rad;
    const std::vector<double> off = EvenedAgainstRing(options, test::MakeSimulatedMap(options));
    EXPECT_GE(off.size(), 12u);
    for (const double one : off) EXPECT_NEAR(one, 0.0, 0.02);
  }
}

}  // namespace
}  // namespace skyquilt::render
