// A rig of three cameras over ground of known reflectance: its bands are laid on each other and come out as
// the ground was.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <mutex>

#include "core/bands/radiometry.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "core/geo/web_mercator.h"
#include "core/render/bands/band_cache.h"
#include "core/render/bands/fit_band_cameras.h"
#include "core/render/bands/measure_targets.h"
#include "core/render/bands/register_bands.h"
#include "core/render/bands/render_bands.h"
#include "core/render/exposure/estimate_exposure.h"
#include "core/render/plan_mosaic.h"
#include "tests/support/value_of.h"

namespace skyquilt::render {
namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr double kHeightM = 50.0;
constexpr double kLevelsOfWhite = 50'000.0, kBlack = 4'000.0;
const std::vector<std::string> kBands = {"green", "red", "nir"};

// Between 0 and 1, the same at every call: smoothed noise of two sizes.
double Noise(double x, double y) {
  const auto at = [](std::int64_t i, std::int64_t j) {
    std::uint64_t h = static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ULL ^
                      static_cast<std::uint64_t>(j) * 0xC2B2AE3D27D4EB4FULL;
    h ^= h >> 29;
    h *= 0xBF58476D1CE4E5B9ULL;
    h ^= h >> 32;
    return static_cast<double>(h >> 11) * 0x1.0p-53;
  };
  const double i = std::floor(x), j = std::floor(y), u = x - i, v = y - j;
  const double su = u * u * (3 - 2 * u), sv = v * v * (3 - 2 * v);
  const auto a = static_cast<std::int64_t>(i), b = static_cast<std::int64_t>(j);
  return (1 - sv) * ((1 - su) * at(a, b) + su * at(a + 1, b)) +
         sv * ((1 - su) * at(a, b + 1) + su * at(a + 1, b + 1));
}

// Plants are dark in green and red and bright in the near infrared.
double Reflectance(const std::string& band, const Eigen::Vector2d& ground) {
  const double plants =
      0.6 * Noise(ground.x() / 1.7, ground.y() / 1.7) + 0.4 * Noise(ground.x(), ground.y() + 90.0);
  if (band == "nir") return 0.1 + 0.6 * plants;
  return (band == "green" ? 0.35 : 0.3) - 0.22 * plants;
}

struct Rig {
  std::map<std::string, camera::Intrinsics> lenses;
  std::map<std::string, Eigen::Vector3d> turns_rad;  // of band_from_reference
};

Rig MakeRig() {
  Rig rig;
  for (const std::string& band : kBands)
    rig.lenses[band] = camera::Intrinsics::Centered(kWidth, kHeight, 620.0);
  rig.turns_rad["green"] = Eigen::Vector3d::Zero();
  rig.lenses["red"].focal_x_px = rig.lenses["red"].focal_y_px = 624.0;
  rig.turns_rad["red"] = {0.012, -0.02, 0.006};
  rig.lenses["nir"].center_x_px += 6.0;
  rig.turns_rad["nir"] = {-0.03, 0.009, -0.01};
  return rig;
}

// Each capture's shutters open at other moments: the rig's rotation wavers.
Eigen::Quaterniond BandFromReference(const Rig& rig, const std::string& band, std::size_t capture) {
  Eigen::Vector3d waver = Eigen::Vector3d::Zero();
  if (band != "green")
    waver = std::sin(static_cast<double>(capture) + 1.0) * Eigen::Vector3d(0.001, -0.0015, 0.0005);
  return geo::RotationFromVector(rig.turns_rad.at(band) + waver);
}

geo::Rigid3 ReferencePose(std::size_t capture) {
  Eigen::Matrix3d down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  const Eigen::Quaterniond turned =
      geo::RotationFromVector({0.02 * std::cos(static_cast<double>(capture)), 0.03, 0.1}) *
      Eigen::Quaterniond(down);
  return geo::Rigid3::FromRotationAndTargetOrigin(turned,
                                                  {12.0 * static_cast<double>(capture), 1.0, kHeightM});
}

std::string NameOf(std::size_t capture, const std::string& band) {
  return std::to_string(capture) + "_" + band;
}

// What a camera of the rig sees.
image::SampleImage DrawnBand(std::size_t capture, const std::string& band) {
  const Rig rig = MakeRig();
  const camera::Intrinsics& lens = rig.lenses.at(band);
  const Eigen::Quaterniond cam_from_enu =
      BandFromReference(rig, band, capture) * ReferencePose(capture).rotation;
  const Eigen::Vector3d center = ReferencePose(capture).TargetOriginInSource();
  image::SampleImage image{kWidth, kHeight, {}};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Eigen::Vector3d ray =
          cam_from_enu.conjugate() * lens.Unproject({static_cast<double>(x), static_cast<double>(y)});
      const Eigen::Vector3d ground = center - center.z() / ray.z() * ray;
      image.samples.push_back(
          static_cast<std::uint16_t>(kBlack + kLevelsOfWhite * Reflectance(band, ground.head<2>()) + 0.5));
    }
  }
  return image;
}

// Draws what the rig's cameras see, once for all cases.
class RigSource final : public flight::PhotoSource {
 public:
  Result<image::DecodedImage> Decode(const flight::Photo& photo, int) const override {
    auto samples = DecodeSamples(photo);
    image::DecodedImage image{kWidth, kHeight, {}};
    for (const std::uint16_t sample : samples->samples) {
      for (int c = 0; c < 3; ++c) image.rgb.push_back(static_cast<std::uint8_t>(sample >> 8));
    }
    return image;
  }
  Result<image::SampleImage> DecodeSamples(const flight::Photo& photo) const override {
    if (photo.name == damaged) return Error{ErrorCode::kCorrupt, "The picture is damaged.", ""};
    if (!overexposed.empty() && photo.name.ends_with(overexposed))
      return image::SampleImage{kWidth, kHeight, std::vector<std::uint16_t>(kWidth * kHeight, 65'520)};
    static std::mutex mutex;
    static std::map<std::string, image::SampleImage> drawn;
    const std::lock_guard lock(mutex);
    const auto [kept, is_new] = drawn.try_emplace(photo.name);
    if (is_new) kept->second = DrawnBand(std::stoul(photo.name), photo.name.substr(photo.name.find('_') + 1));
    return kept->second;
  }
  std::string damaged, overexposed;  // a picture; a band
};

bands::Radiometry RigRadiometry() {
  bands::Radiometry radiometry;
  radiometry.black.fill(kBlack);
  radiometry.per_level = 1.0 / kLevelsOfWhite;
  radiometry.calibration = bands::Calibration::kReflectance;
  return radiometry;
}

struct RigFlight {
  alignment::AlignedFlight references;
  bands::Captures captures;
};

// All lenses recorded as the green one's.
RigFlight Fly(std::size_t captures) {
  RigFlight flown;
  flown.references.frame = geo::LocalFrame(geo::Wgs84{47.0, 8.0, 400.0});
  flown.captures.reference_band = "green";
  for (const std::string& band : kBands) flown.captures.bands.push_back({band, {}, {}, {}, ""});
  for (std::size_t i = 0; i < captures; ++i) {
    bands::Capture& capture = flown.captures.captures.emplace_back();
    capture.reference = NameOf(i, "green");
    for (const std::string& band : kBands) {
      flight::Photo photo;
      photo.name = NameOf(i, band);
      photo.camera_key = band;
      photo.intrinsics = camera::Intrinsics::Centered(kWidth, kHeight, 620.0);
      bands::BandFacts facts;
      facts.name = band;
      facts.radiometry = RigRadiometry();
      capture.photos.push_back({photo, facts});
    }
    alignment::AlignedPhoto reference;
    reference.photo = capture.photos.front().photo;
    reference.intrinsics = reference.photo.intrinsics;
    reference.cam_from_enu = ReferencePose(i);
    reference.height_above_ground_m = kHeightM;
    reference.placement = alignment::Placement::kAligned;
    flown.references.photos.push_back(reference);
  }
  return flown;
}

BandCameras Register(const RigFlight& flown, const RigSource& source, int threads = 2) {
  SilentProgress progress;
  return test::ValueOf(RegisterBands(flown.references, ground::GroundSurface::Plane(0.0), flown.captures,
                                     source, {threads}, progress));
}

// Root mean square of how far off a band's camera shows the ground, pixels.
double OffPx(const Rig& rig, const BandCamera& camera, const std::string& band, std::size_t capture) {
  double squares = 0.0;
  int count = 0;
  for (double y = 40; y < kHeight; y += 80) {
    for (double x = 40; x < kWidth; x += 80) {
      const Eigen::Vector3d center = ReferencePose(capture).TargetOriginInSource();
      const Eigen::Vector3d ray =
          (BandFromReference(rig, band, capture) * ReferencePose(capture).rotation).conjugate() *
          rig.lenses.at(band).Unproject({x, y});
      const Eigen::Vector3d ground = center - center.z() / ray.z() * ray;
      const auto pixel = camera.photo.intrinsics.Project(camera.photo.cam_from_enu * ground);
      if (!pixel) return 1e9;
      squares += (*pixel - Eigen::Vector2d(x, y)).squaredNorm();
      ++count;
    }
  }
  return std::sqrt(squares / count);
}

TEST(RegisterBandsTest, FindsTheRigWithinAFractionOfAPixel) {
  const Rig rig = MakeRig();
  const RigFlight flown = Fly(3);
  const BandCameras cameras = Register(flown, RigSource());
  EXPECT_TRUE(cameras.warnings.empty());
  for (std::size_t band = 0; band < kBands.size(); ++band) {
    EXPECT_EQ(cameras.registrations[band].pictures, 3);
    EXPECT_EQ(cameras.registrations[band].measured, 3);
    EXPECT_LT(cameras.registrations[band].residual_px, 0.2) << kBands[band];
    for (std::size_t i = 0; i < 3; ++i) {
      ASSERT_TRUE(cameras.captures[i].cameras[band].has_value());
      EXPECT_LT(OffPx(rig, *cameras.captures[i].cameras[band], kBands[band], i), 0.2) << kBands[band];
    }
  }
}

TEST(RegisterBandsTest, DoesNotDependOnThreads) {
  const RigSource source;
  const RigFlight flown = Fly(3);
  const BandCameras one = Register(flown, source, 1), four = Register(flown, source, 4);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t band = 0; band < kBands.size(); ++band) {
      const BandCamera &a = *one.captures[i].cameras[band], &b = *four.captures[i].cameras[band];
      EXPECT_EQ(a.photo.intrinsics, b.photo.intrinsics);
      EXPECT_TRUE(a.photo.cam_from_enu.rotation.coeffs() == b.photo.cam_from_enu.rotation.coeffs());
    }
  }
}

TEST(RegisterBandsTest, ADamagedPictureCostsItsBandThereAlone) {
  RigSource source;
  source.damaged = "1_nir";
  const BandCameras cameras = Register(Fly(3), source);
  EXPECT_FALSE(cameras.captures[1].cameras[2].has_value());
  EXPECT_TRUE(cameras.captures[1].cameras[1].has_value());
  EXPECT_TRUE(cameras.captures[0].cameras[2].has_value());
  ASSERT_EQ(cameras.warnings.size(), 1U);
  EXPECT_NE(InWords(cameras.warnings[0]).find("1_nir"), std::string::npos);
}

TEST(RegisterBandsTest, AReferenceWithoutEdgesLeavesBandsToTheOthers) {
  RigSource source;
  source.damaged = "1_green";
  const BandCameras cameras = Register(Fly(3), source);
  // The rig wavers by a pixel or so; without it the usual rotation would be exact.
  EXPECT_LT(OffPx(MakeRig(), *cameras.captures[1].cameras[1], "red", 1), 3.0);
  ASSERT_FALSE(cameras.warnings.empty());
}

// A round target on the ground of the flight, of which the list says the truth.
flight::GroundTarget TargetAt(const RigFlight& flown, const Eigen::Vector2d& place, double radius_m) {
  const geo::Wgs84 center = flown.references.frame.Wgs84FromEnu({place.x(), place.y(), 0.0});
  flight::GroundTarget target{{center.lat_deg, center.lon_deg}, radius_m, {}};
  for (const std::string& band : kBands) target.reflectance.bands[band] = Reflectance(band, place);
  return target;
}

TEST(MeasureTargetsTest, FindsTheFactorOfEachBandByGroundOfKnownReflectance) {
  const RigSource source;
  RigFlight flown = Fly(3);
  const std::map<std::string, double> wrong_by = {{"green", 1.0}, {"red", 0.5}, {"nir", 1.8}};
  for (bands::Band& band : flown.captures.bands) band.calibration = bands::Calibration::kRelative;
  for (bands::Capture& capture : flown.captures.captures) {
    for (bands::BandPhoto& photo : capture.photos)
      photo.facts.radiometry.per_level *= wrong_by.at(photo.facts.name);
  }
  const BandCameras cameras = Register(flown, source);
  flown.captures.targets = {TargetAt(flown, {10.0, 2.0}, 0.15), TargetAt(flown, {14.0, -3.0}, 0.15)};
  const auto measured = [&] {
    return MeasureTargets(flown.references, ground::GroundSurface::Plane(0.0), flown.captures, cameras,
                          source);
  };
  const TargetFactors factors = measured();
  EXPECT_TRUE(factors.warnings.empty());
  for (std::size_t band = 0; band < kBands.size(); ++band) {
    ASSERT_EQ(factors.by_band[band].size(), 2U) << kBands[band];
    for (const double factor : factors.by_band[band])
      EXPECT_NEAR(factor * wrong_by.at(kBands[band]), 1.0, 0.03) << kBands[band];
  }
  // One that lies outside, one that says nothing of red, and levels that nobody can scale.
  flown.captures.targets = {TargetAt(flown, {4000.0, 0.0}, 1.0), TargetAt(flown, {10.0, 2.0}, 0.15)};
  flown.captures.targets[1].reflectance.bands.erase("red");
  flown.captures.bands[2].calibration = bands::Calibration::kLevels;
  const TargetFactors fewer = measured();
  EXPECT_EQ(fewer.by_band[0].size(), 1U);
  EXPECT_TRUE(fewer.by_band[1].empty() && fewer.by_band[2].empty());
  ASSERT_EQ(fewer.warnings.size(), 1U);
  EXPECT_NE(InWords(fewer.warnings[0]).find("Target 1"), std::string::npos);
}

TEST(MeasureTargetsTest, AnOverexposedTargetSaysNothingOfItsBandAndIsSaid) {
  RigSource source;
  RigFlight flown = Fly(3);
  for (bands::Band& band : flown.captures.bands) band.calibration = bands::Calibration::kRelative;
  const BandCameras cameras = Register(flown, source);
  flown.captures.targets = {TargetAt(flown, {10.0, 2.0}, 0.15)};
  source.overexposed = "red";
  const TargetFactors factors =
      MeasureTargets(flown.references, ground::GroundSurface::Plane(0.0), flown.captures, cameras, source);
  EXPECT_EQ(factors.by_band[0].size(), 1U);
  EXPECT_TRUE(factors.by_band[1].empty());
  EXPECT_EQ(factors.by_band[2].size(), 1U);
  ASSERT_EQ(factors.warnings.size(), 1U);
  EXPECT_NE(
      InWords(factors.warnings[0]).find("Target 1 of known reflectance is not used for red: it is over"),
      std::string::npos);
}

TEST(MeasureTargetsTest, AnUnevenTargetIsSaid) {
  const RigSource source;
  RigFlight flown = Fly(3);
  for (bands::Band& band : flown.captures.bands) band.calibration = bands::Calibration::kRelative;
  const BandCameras cameras = Register(flown, source);
  flown.captures.targets = {TargetAt(flown, {12.0, 0.0}, 8.0)};
  const TargetFactors factors =
      MeasureTargets(flown.references, ground::GroundSurface::Plane(0.0), flown.captures, cameras, source);
  ASSERT_EQ(factors.warnings.size(), 1U);
  EXPECT_NE(InWords(factors.warnings[0]).find("uneven"), std::string::npos);
}

TEST(FitBandCamerasTest, TooFewOrContradictingSightingsSayNothing) {
  const BandLens lens{camera::Intrinsics::Centered(kWidth, kHeight, 620.0), {}};
  BandStand stand;
  EXPECT_FALSE(FitStand(lens, 1.0, stand));
  for (int i = 0; i < 30; ++i) {
    BandSighting sighting;
    sighting.in_reference_cam = {i % 6 - 3.0, i / 6 - 2.0, 10.0};
    sighting.pixel_in_band = {Noise(i, 3.0) * 640.0, Noise(i, 9.0) * 480.0};
    stand.sightings.push_back(sighting);
  }
  EXPECT_FALSE(FitStand(lens, 1.0, stand));
  EXPECT_TRUE(stand.band_from_reference.isApprox(Eigen::Quaterniond::Identity()));
  for (BandSighting& sighting : stand.sightings) sighting.in_reference_cam.z() = -10.0;  // behind
  EXPECT_FALSE(FitStand(lens, 1.0, stand));
  EXPECT_EQ(FitBandLens(lens, {stand}).intrinsics, lens.intrinsics);
  EXPECT_TRUE(FitBandField(lens.intrinsics, {stand}).IsZero());
}

TEST(BandCacheTest, ReadsBetweenValuesAndNothingBeyond) {
  image::FloatImage picture{5, 4, {}};
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 5; ++x) picture.values.push_back(static_cast<float>(x + 10 * y));
  EXPECT_NEAR(ValueAt(picture, 1.25F, 1.5F), 16.25F, 1e-4F);
  EXPECT_FLOAT_EQ(ValueAt(picture, 4.0F, 3.0F), 34.0F);
  for (const auto& [x, y] : {std::pair{-0.1F, 1.0F}, {4.1F, 1.0F}, {1.0F, 3.1F}, {NAN, 1.0F}})
    EXPECT_TRUE(std::isnan(ValueAt(picture, x, y)));
}

// Keeps all blocks.
class KeptBands final : public bands::BandSink {
 public:
  Result<void> Begin(const bands::BandRaster& begun) override {
    raster = begun;
    return {};
  }
  Result<void> Put(int left_px, int top_px, const std::vector<std::vector<float>>& values) override {
    blocks[{left_px, top_px}] = values;
    return {};
  }
  bands::BandRaster raster;
  std::map<std::pair<int, int>, std::vector<std::vector<float>>> blocks;
};

// `later`: what is drawn from, once the bands are registered.
Result<void> Render(const RigFlight& flown, const RigSource& source, int threads, KeptBands& kept,
                    const RigSource* later = nullptr) {
  const ground::GroundSurface ground = ground::GroundSurface::Plane(0.0);
  const auto plan = test::ValueOf(PlanMosaic(flown.references, ground, {}));
  std::vector<Thumbnail> thumbnails;
  for (const alignment::AlignedPhoto& photo : flown.references.photos)
    thumbnails.push_back(MakeThumbnail(photo.photo, *source.Decode(photo.photo, 1)));
  const ExposureModel exposure = EstimateExposure(flown.references, ground, thumbnails);
  const SeamMap seams = BuildSeamMap(flown.references, ground, plan, exposure, thumbnails, {});
  const BandCameras cameras = Register(flown, source, threads);
  SilentProgress progress;
  return RenderBands({flown.references, ground, seams, plan, cameras, flown.captures},
                     later != nullptr ? *later : source, {threads}, kept, progress);
}

TEST(RenderBandsTest, ShowsTheGroundsReflectance) {
  const RigFlight flown = Fly(3);
  const RigSource source;
  KeptBands kept;
  ASSERT_TRUE(Render(flown, source, 2, kept));
  ASSERT_EQ(kept.raster.bands.size(), 3U);
  for (std::size_t band = 0; band < kBands.size(); ++band) {
    double squares = 0.0;
    std::int64_t count = 0;
    for (const auto& [corner, values] : kept.blocks) {
      for (int y = 0; y < kept.raster.block_px; y += 3) {
        for (int x = 0; x < kept.raster.block_px; x += 3) {
          const float value = values[band][static_cast<std::size_t>(y) * kept.raster.block_px + x];
          if (std::isnan(value)) continue;
          const geo::LatLon place = geo::LatLonFromMerc(
              {kept.raster.west_in_merc_m + (corner.first + x + 0.5) * kept.raster.pixel_in_merc_m,
               kept.raster.north_in_merc_m - (corner.second + y + 0.5) * kept.raster.pixel_in_merc_m});
          const Eigen::Vector3d ground = flown.references.frame.VerticalAt(place).AtHeight(0.0);
          const double miss = value - Reflectance(kBands[band], ground.head<2>());
          squares += miss * miss;
          ++count;
        }
      }
    }
    ASSERT_GT(count, 20'000);
    EXPECT_LT(std::sqrt(squares / static_cast<double>(count)), 0.012) << kBands[band];
  }
}

// A disk that is pulled out: holes in a raster would pass for ground without values.
TEST(RenderBandsTest, APictureThatIsGoneSinceIsSaid) {
  const RigSource source;
  RigSource later;
  later.damaged = "1_red";
  KeptBands kept;
  const Result<void> rendered = Render(Fly(2), source, 2, kept, &later);
  ASSERT_FALSE(rendered.ok());
  EXPECT_EQ(rendered.error().code, ErrorCode::kCorrupt);
}

// A raster of all between them would take hours, and a disk.
TEST(RenderBandsTest, FieldsFarApartHaveNoRaster) {
  RigFlight flown = Fly(2);
  geo::Rigid3& pose = flown.references.photos.back().cam_from_enu;
  pose = geo::Rigid3::FromRotationAndTargetOrigin(pose.rotation, {40'000.0, 40'000.0, kHeightM});
  const RigSource source;
  KeptBands kept;
  const Result<void> rendered = Render(flown, source, 2, kept);
  ASSERT_FALSE(rendered.ok());
  EXPECT_EQ(rendered.error().code, ErrorCode::kUnprocessable);
  EXPECT_EQ(flight::WhyOf(rendered.error()).code, flight::RemarkCode::kFieldsFarApart);
  EXPECT_TRUE(kept.raster.bands.empty());
}

TEST(RenderBandsTest, DoesNotDependOnThreads) {
  const RigFlight flown = Fly(2);
  const RigSource source;
  KeptBands one, four;
  ASSERT_TRUE(Render(flown, source, 1, one));
  ASSERT_TRUE(Render(flown, source, 4, four));
  ASSERT_EQ(one.blocks.size(), four.blocks.size());
  for (const auto& [corner, values] : one.blocks) {
    for (std::size_t band = 0; band < values.size(); ++band) {
      const std::vector<float>& other = four.blocks.at(corner)[band];
      for (std::size_t i = 0; i < values[band].size(); ++i)
        ASSERT_TRUE(values[band][i] == other[i] || (std::isnan(values[band][i]) && std::isnan(other[i])));
    }
  }
}

}  // namespace
}  // namespace skyquilt::render
