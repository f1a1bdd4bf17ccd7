#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/geo/rigid3.h"
#include "core/render/exposure/estimate_exposure.h"
#include "core/render/exposure/exposure_samples.h"
#include "core/render/exposure/light_equations.h"
#include "core/simulate/world/render_photo.h"
#include "tests/support/simulated_map.h"

namespace skyquilt::render {
namespace {

// By how much the same ground differs between two photos that see it, as a logarithm: the root mean square
// over all spots and channels, by what the photos themselves hold and as the tones even them.
struct Disagreement {
  double before = 0.0, after = 0.0;
};

Disagreement DisagreementOf(const test::SimulatedMap& map, const ExposureModel& exposure) {
  const auto samples = SampleExposure(map.flight, map.ground, map.thumbnails);
  double before = 0.0, after = 0.0;
  int count = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const ExposureSample &a = samples[i - 1], &b = samples[i];
    if (a.spot != b.spot) continue;
    const auto shown = [&](const ExposureSample& sample, std::size_t channel) {
      const PhotoTone& tone = exposure.tones[sample.photo];
      return static_cast<double>(sample.log_value[channel]) +
             std::log(tone.gain[channel] * tone.shade.At(static_cast<double>(sample.place[0]),
                                                         static_cast<double>(sample.place[1]))[channel]);
    };
    for (std::size_t channel = 0; channel < 3; ++channel) {
      before += std::pow(static_cast<double>(a.log_value[channel] - b.log_value[channel]), 2);
      after += std::pow(shown(a, channel) - shown(b, channel), 2);
      ++count;
    }
  }
  return {std::sqrt(before / count), std::sqrt(after / count)};
}

TEST(Exposure, EvensLensGainsAndSun) {
  simulate::SimulateOptions options = test::SmallPhotos(24);
  options.vignetting = 0.25;
  options.exposure_jitter = 0.05;
  options.hot_spot = 0.3;
  const test::SimulatedMap map = test::MakeSimulatedMap(options);
  const Disagreement off = DisagreementOf(map, map.exposure);
  EXPECT_GT(off.before, 0.08);
  EXPECT_LT(off.after, 0.25 * off.before);
}

TEST(Exposure, FindsTheHotSpotOppositeTheSun) {
  simulate::SimulateOptions options = test::SmallPhotos(24);
  options.hot_spot = 0.4;
  const test::SimulatedMap map = test::MakeSimulatedMap(options);
  const Eigen::Vector3d sun = simulate::SunDirection(options.origin, options.start);
  const Eigen::Vector2d opposite = -sun.head<2>() / sun.z();
  const auto& spot = map.exposure.light.directions.hot_spot;
  ASSERT_TRUE(spot.has_value());
  EXPECT_LT((*spot - opposite).norm(), 0.06) << spot->transpose() << " is not " << opposite.transpose();
}

TEST(Exposure, FindsNoHotSpotWhereThereIsNone) {
  simulate::SimulateOptions options = test::SmallPhotos(24);
  options.vignetting = 0.2;
  options.exposure_jitter = 0.05;
  EXPECT_FALSE(test::MakeSimulatedMap(options).exposure.light.directions.hot_spot.has_value());
}

TEST(Exposure, LeavesPhotosThatAgreeAsTheyAre) {
  simulate::SimulateOptions options = test::SmallPhotos(24);
  options.world.gradient_per_km = 1.0;  // of the field itself
  const test::SimulatedMap map = test::MakeSimulatedMap(options);
  for (const PhotoTone& tone : map.exposure.tones) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      EXPECT_NEAR(tone.gain[channel], 1.0, 0.02);
      for (const double y : {-0.6, 0.0, 0.6}) {
        for (const double x : {-0.8, 0.0, 0.8}) EXPECT_NEAR(tone.shade.At(x, y)[channel], 1.0, 0.04);
      }
    }
  }
}

// A drift of exposures across the flight is what no overlap shows.
TEST(Exposure, KnowsADriftByRecordedExposuresThatPhotosShow) {
  simulate::SimulateOptions options = test::SmallPhotos(24);
  options.exposure_jitter = 0.08;
  options.is_exposure_recorded = true;
  test::SimulatedMap map = test::MakeSimulatedMap(options);
  const auto worst = [](const ExposureModel& exposure, const simulate::SimulatedFlight& simulated) {
    double error = 0.0, mean = 0.0;
    const auto count = static_cast<double>(exposure.photos.size());
    for (std::size_t i = 0; i < exposure.photos.size(); ++i)
      mean += std::log(exposure.photos[i].gain[1] * simulated.photos[i].render.exposure_gain) / count;
    for (std::size_t i = 0; i < exposure.photos.size(); ++i) {
      const double log = std::log(exposure.photos[i].gain[1] * simulated.photos[i].render.exposure_gain);
      error = std::max(error, std::abs(log - mean));
    }
    return error;
  };
  const double known = worst(map.exposure, map.truth);
  for (auto& photo : map.flight.photos) photo.photo.exposure_log2.reset();
  const double unknown = worst(EstimateExposure(map.flight, map.ground, map.thumbnails), map.truth);
  EXPECT_LT(known, 0.02);
  EXPECT_GT(unknown, 2.0 * known);
}

// The light changed and the camera followed it: photos show nothing of what it records.
TEST(Exposure, DoesNotBelieveRecordedExposuresThatPhotosDoNotShow) {
  test::SimulatedMap map = test::MakeSimulatedMap(test::SmallPhotos(24));
  for (std::size_t i = 0; i < map.flight.photos.size(); ++i)
    map.flight.photos[i].photo.exposure_log2 = 0.7 * std::sin(1.7 * static_cast<double>(i));
  map.flight.photos[3].photo.exposure_log2 = 40.0;
  map.flight.photos[4].photo.exposure_log2.reset();
  const ExposureModel exposure = EstimateExposure(map.flight, map.ground, map.thumbnails);
  for (const PhotoLight& photo : exposure.photos) EXPECT_NEAR(photo.gain[1], 1.0, 0.02);
}

TEST(Exposure, AddedPhotosGetTheLightOfTheOthers) {
  simulate::SimulateOptions options = test::SmallPhotos(24);
  options.vignetting = 0.25;
  options.hot_spot = 0.3;
  const test::SimulatedMap map = test::MakeSimulatedMap(options);
  KnownExposure known{map.exposure.light, map.exposure.photos};
  known.photos.resize(known.photos.size() - 4);
  const ExposureModel grown = ExtendExposure(map.flight, map.ground, map.thumbnails, known);
  ASSERT_EQ(grown.photos.size(), map.exposure.photos.size());
  for (std::size_t i = 0; i < grown.photos.size(); ++i) {
    EXPECT_EQ(grown.tones[i].shade.terms, map.exposure.tones[i].shade.terms);
    for (std::size_t channel = 0; channel < 3; ++channel)
      EXPECT_NEAR(grown.photos[i].gain[channel], map.exposure.photos[i].gain[channel], 0.02);
  }
}

// Those furthest from the map may have been flown first.
TEST(Exposure, AddedPhotosHaveTheLightOfTheMapInWhateverOrderTheyCome) {
  simulate::SimulateOptions options = test::SmallPhotos(24);
  options.trajectory.front_overlap = options.trajectory.side_overlap = 0.5;
  const test::SimulatedMap map = test::MakeSimulatedMap(options);
  constexpr std::size_t kFinished = 3;
  const auto away_m = [&](std::size_t i) {
    return (map.flight.photos[i].cam_from_enu.TargetOriginInSource() -
            map.flight.photos[0].cam_from_enu.TargetOriginInSource())
        .norm();
  };
  std::vector<std::size_t> order(map.flight.photos.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return away_m(a) < away_m(b); });
  std::reverse(order.begin() + kFinished, order.end());
  alignment::AlignedFlight flight = map.flight;
  std::vector<Thumbnail> thumbnails = map.thumbnails;
  for (std::size_t i = 0; i < order.size(); ++i) {
    flight.photos[i] = map.flight.photos[order[i]];
    thumbnails[i] = map.thumbnails[order[i]];
  }
  KnownExposure known;
  known.photos.assign(kFinished, PhotoLight{.gain = {1.3, 1.3, 1.3}});
  const ExposureModel grown = ExtendExposure(flight, map.ground, thumbnails, known);
  for (const PhotoLight& photo : grown.photos) {
    for (const double gain : photo.gain) EXPECT_NEAR(gain, 1.3, 0.06);
  }
}

TEST(Exposure, KnowsNothingOfPhotosThatShareNoGround) {
  test::SimulatedMap map = test::MakeSimulatedMap(test::SmallPhotos(24));
  for (std::size_t i = 0; i < map.flight.photos.size(); ++i)
    map.flight.photos[i].cam_from_enu.translation.x() += 1000.0 * static_cast<double>(i);
  const ExposureModel exposure = EstimateExposure(map.flight, map.ground, map.thumbnails);
  for (const PhotoTone& tone : exposure.tones) {
    EXPECT_EQ(tone.gain, (std::array{1.0, 1.0, 1.0}));
    EXPECT_TRUE(tone.shade.IsEven());
  }
}

// Of one from so high above not more spots than of one that still is asked at all of them.
TEST(Exposure, PhotosThatReachFarHaveSamplesToo) {
  test::SimulatedMap map = test::MakeSimulatedMap(test::SmallPhotos(24));
  constexpr std::uint32_t kHigh = 5;
  geo::Rigid3& pose = map.flight.photos[kHigh].cam_from_enu;
  const Eigen::Vector3d below = pose.TargetOriginInSource();
  pose = geo::Rigid3::FromRotationAndTargetOrigin(pose.rotation, {below.x(), below.y(), 20.0 * below.z()});
  const std::vector<ExposureSample> samples = SampleExposure(map.flight, map.ground, map.thumbnails);
  const auto of_high = std::count_if(samples.begin(), samples.end(),
                                     [](const ExposureSample& sample) { return sample.photo == kHigh; });
  EXPECT_GT(of_high, 8);
  EXPECT_LT(of_high, 122 * 122);
}

// A thousand photos of one place would be many gigabytes otherwise.
TEST(SolveLight, SumsUpTheEquationsOfSpotsThatManyPhotosShow) {
  constexpr std::uint32_t kPhotos = 500, kSpots = 20;  // five million gains by gains
  const auto gain = [](std::uint32_t photo) { return 0.1 * std::sin(0.37 * photo); };
  std::vector<ExposureSample> samples;
  for (std::uint32_t spot = 0; spot < kSpots; ++spot) {
    for (std::uint32_t photo = 0; photo < kPhotos; ++photo) {
      ExposureSample sample;
      sample.spot = spot;
      sample.photo = photo;
      sample.log_value.fill(static_cast<float>(0.2 * spot - gain(photo)));
      samples.push_back(sample);
    }
  }
  LightTerms terms;
  terms.camera_of_photo.assign(kPhotos, LightTerms::kNone);
  terms.exposure_of_photo.assign(kPhotos, 0.0);
  terms.directions.widest_look = 1.0;
  const SolvedLight light = SolveLight(samples, 0, terms);
  double mean = 0.0, off = 0.0;
  for (std::uint32_t photo = 0; photo < kPhotos; ++photo)
    mean += (light.log_gains[photo] - gain(photo)) / kPhotos;
  for (std::uint32_t photo = 0; photo < kPhotos; ++photo)
    off = std::max(off, std::abs(light.log_gains[photo] - gain(photo) - mean));
  EXPECT_LT(off, 0.03);
}

// A cloud comes when half of the photos of a line are taken: a step, not a slope of light over the whole map,
// which photos that see the ground from two sides cannot tell from gains that grow evenly.
TEST(SolveLight, ACloudAtHalfFlightIsAStep) {
  constexpr std::uint32_t kPhotos = 30, kSpots = 3000;
  constexpr double kStep = 0.36, kApart = 0.3, kSeenTo = 0.5;
  const auto gain = [](std::uint32_t photo) { return photo < kPhotos / 2 ? 0.0 : kStep; };
  std::vector<ExposureSample> samples;
  for (std::uint32_t spot = 0; spot < kSpots; ++spot) {
    for (std::uint32_t photo = 0; photo < kPhotos; ++photo) {
      const double x = 0.003 * spot - kApart * photo, y = 0.3 * std::sin(1.7 * spot);
      if (std::abs(x) > kSeenTo) continue;
      ExposureSample sample;
      sample.spot = spot;
      sample.photo = photo;
      sample.look = sample.place = {static_cast<float>(x), static_cast<float>(y)};
      sample.log_value.fill(static_cast<float>(0.1 * std::sin(2.3 * spot) - gain(photo)));
      samples.push_back(sample);
    }
  }
  LightTerms terms;
  terms.camera_of_photo.assign(kPhotos, LightTerms::kNone);
  terms.exposure_of_photo.assign(kPhotos, 0.0);
  terms.directions.widest_look = 0.6;
  const SolvedLight light = SolveLight(samples, 0, terms);
  for (std::uint32_t photo = 1; photo < kPhotos; ++photo) {
    const double step = light.log_gains[photo] - light.log_gains[photo - 1];
    EXPECT_NEAR(step, gain(photo) - gain(photo - 1), 0.01) << photo;
  }
}

TEST(LightModel, ShadeUndoesWhatLensAndSunDid) {
  LightModel light;
  light.directions.widest_look = 0.8;
  light.cameras["a camera"][0] = {-0.2, -0.05, 0.0, 0.02, -0.03};
  light.cameras["a camera"][1] = {-0.25};
  light.directions.hot_spot = Eigen::Vector2d(0.2, 0.3);
  for (DirectionTerms& channel : light.of_directions) channel[kSmoothDirectionTerms + 1] = 0.15;
  light.of_directions[0] = {0.1, -0.05, 0.03, 0.0, -0.02, 0.01};
  light.of_directions[2] = {0.0, 0.15, 0.0, 0.04};
  for (std::size_t hill = 0; hill < kSpotTerms; ++hill)
    light.of_directions[0][kSmoothDirectionTerms + hill] = 0.1 - 0.03 * static_cast<double>(hill);
  alignment::AlignedPhoto photo;
  photo.photo.camera_key = "a camera";
  photo.intrinsics = camera::Intrinsics::Centered(800, 600, 640.0);
  // Top of the picture to the north-east, leaning by 5 degrees.
  photo.cam_from_enu.rotation = Eigen::AngleAxisd(0.09, Eigen::Vector3d::UnitX()) *
                                Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()) *
                                Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());
  const std::array<double, 3> shares{0.5, 1.0, 1.5};
  const Shade shade = ShadeOf(light, photo, shares);
  const ShadeGrid grid(shade, photo.intrinsics);
  for (const Eigen::Vector2d& pixel :
       {Eigen::Vector2d(0, 0), {799, 0}, {130, 420}, {400, 300}, {470, 160}, {545, 100}, {799, 599}}) {
    const Eigen::Vector2d place = (pixel - Eigen::Vector2d(399.5, 299.5)) / 500.0;
    const Eigen::Vector2d look =
        LookOf(photo.cam_from_enu.rotation.conjugate() * photo.intrinsics.Unproject(pixel));
    const auto shown = shade.At(place.x(), place.y());
    const auto drawn = grid.At(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const auto direction = light.directions.Basis(look);
      const auto camera = CameraBasis(place);
      double brighter = 0.0;
      for (std::size_t k = 0; k < direction.size(); ++k)
        brighter += (k < kSmoothDirectionTerms ? 1.0 : shares[channel]) * direction[k] *
                    light.of_directions[channel][k];
      for (std::size_t k = 0; k < camera.size(); ++k)
        brighter += camera[k] * light.cameras["a camera"][channel][k];
      EXPECT_NEAR(shown[channel] * std::exp(brighter), 1.0, 0.005) << pixel.transpose();
      EXPECT_NEAR(static_cast<double>(drawn[channel]), shown[channel], 0.003) << pixel.transpose();
    }
  }
}

TEST(LightModel, LooksThatDoNotPointDownAreBounded) {
  EXPECT_EQ(LookOf({0.0, 0.0, -1.0}), Eigen::Vector2d::Zero());
  EXPECT_EQ(LookOf({0.0, 0.0, 1.0}), Eigen::Vector2d::Zero());
  EXPECT_NEAR((LookOf({0.3, -0.4, -1.0}) - Eigen::Vector2d(0.3, -0.4)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(LookOf({3.0, 4.0, 2.0}).norm(), 10.0, 1e-12);
  LightModel light;
  light.directions.widest_look = 0.5;
  for (std::size_t i = 0; i < kDirectionTerms; ++i)
    EXPECT_NEAR(light.directions.Basis({3.0, 4.0})[i], light.directions.Basis({0.3, 0.4})[i], 1e-12);
}

TEST(LightModel, APhotoOfOnePixelHasAShade) {
  LightModel light;
  light.directions.widest_look = 1.0;
  light.of_directions[0][0] = 0.3;
  alignment::AlignedPhoto photo;
  photo.intrinsics = camera::Intrinsics::Centered(1, 1, 1.0);
  const Shade shade = ShadeOf(light, photo, {});
  for (const float term : shade.terms[0]) EXPECT_TRUE(std::isfinite(term));
  EXPECT_GT(ShadeGrid(shade, photo.intrinsics).At(0.0f, 0.0f)[0], 0.1f);
}

TEST(ShadePowers, AreAllProductsUpToTheDegree) {
  const auto powers = ShadePowers(2.0, 3.0);
  std::size_t at = 0;
  for (int degree = 0; degree <= kShadeDegree; ++degree) {
    for (int of_y = 0; of_y <= degree; ++of_y, ++at)
      EXPECT_EQ(powers[at], std::pow(2.0, degree - of_y) * std::pow(3.0, of_y));
  }
  EXPECT_EQ(at, powers.size());
}

}  // namespace
}  // namespace skyquilt::render
