// A simulated rig's files, read as any camera's: what comes of their levels is the ground's reflectance.
#include "core/simulate/sensors/band_rig.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/bands/band_facts.h"
#include "core/bands/captures.h"
#include "core/flight/photos/photo_decoder.h"
#include "core/flight/read_flight.h"
#include "core/simulate/simulate_flight.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::simulate {
namespace {

constexpr int kWidth = 320, kHeight = 240;

SimulateOptions SmallRig() {
  SimulateOptions options;
  options.has_band_rig = true;
  options.intrinsics = camera::Intrinsics::Centered(kWidth, kHeight, 240.0);
  options.trajectory.photos = 2;
  options.trajectory.height_m = 40.0;
  options.world.relief_m = 4.0;
  options.write_world = false;
  options.noise_counts = 0.0;
  return options;
}

SimulatedFlight Simulate(const SimulateOptions& options, const std::filesystem::path& folder) {
  SilentProgress progress;
  return test::ValueOf(SimulateFlight(options, folder, progress));
}

TEST(BandRigTest, LevelsAreReadAsReflectance) {
  const test::TemporaryFolder folder;
  const SimulatedFlight flight = Simulate(SmallRig(), folder.path());
  ASSERT_EQ(flight.rig.size(), 5U);
  for (std::size_t capture = 0; capture < 2; ++capture) {
    for (const RigBand& band : flight.rig) {
      const std::string file = test::BytesOf(folder / ("photos/SIM_000" + std::to_string(capture + 1) + "_" +
                                                       std::to_string(band.index + 1) + ".TIF"));
      const std::vector<std::uint8_t> bytes(file.begin(), file.end());
      flight::MemoryBytes source(bytes);
      const auto facts = test::ValueOf(bands::ReadBandFacts(source));
      EXPECT_EQ(facts.radiometry.calibration, bands::Calibration::kReflectance);
      EXPECT_DOUBLE_EQ(*facts.wavelength_nm, band.wavelength_nm);
      const auto levels = test::ValueOf(flight::DecodeSampleBytes(bytes, kWidth, kHeight));
      const image::FloatImage values = bands::ValuesOf(levels, facts.radiometry);
      Eigen::Vector4f of_color = band.reflectance_of_color.cast<float>();
      of_color.tail<3>() /= 255.0F;
      const image::FloatImage truth =
          RenderLight(flight.world, band.lens, BandFromEnu(band, flight.photos[capture].pose), of_color, 1);
      double least = 1.0, most = 0.0;
      // Vignetting is read off nodes every 16 pixels: in so small a picture up to half a percent.
      for (std::size_t i = 0; i < truth.values.size(); ++i) {
        ASSERT_NEAR(values.values[i], truth.values[i], 0.006 * truth.values[i] + 1e-4)
            << band.name << " " << i;
        least = std::min(least, static_cast<double>(truth.values[i]));
        most = std::max(most, static_cast<double>(truth.values[i]));
      }
      EXPECT_GT(least, 0.0);
      EXPECT_GT(most, 1.5 * least);
    }
  }
}

TEST(BandRigTest, BandsDifferInLensLightAndExposure) {
  const std::vector<RigBand> rig = MakeBandRig(camera::Intrinsics::Centered(kWidth, kHeight, 240.0), 3);
  EXPECT_EQ(rig[kReferenceBand].lens, camera::Intrinsics::Centered(kWidth, kHeight, 240.0));
  for (std::size_t band = 0; band < rig.size(); ++band) {
    const double corner =
        rig[band].vignetting[1] * 200.0 * 200.0 + rig[band].vignetting[3] * std::pow(200.0, 4);
    EXPECT_LT(corner, -0.15);
    EXPECT_NE(ExposureOf(rig[band], 0, 3).exposure_us, ExposureOf(rig[band], 1, 3).exposure_us);
    EXPECT_NE(ExposureOf(rig[band], 0, 3).irradiance, ExposureOf(rig[band], 1, 3).irradiance);
    if (band == kReferenceBand) continue;
    EXPECT_NE(rig[band].lens, rig[kReferenceBand].lens);
    EXPECT_GT(rig[band].band_from_reference.angularDistance(Eigen::Quaterniond::Identity()), 1e-3);
  }
}

TEST(BandRigTest, IsReadAsCapturesOfFiveBands) {
  const test::TemporaryFolder folder;
  Simulate(SmallRig(), folder.path());
  SilentProgress progress;
  auto files = test::ValueOf(flight::ListInputFiles({folder / "photos"}));
  auto flight = test::ValueOf(flight::ReadFlight(files, 2, progress));
  const bands::Captures apart = bands::SetBandsApart(flight, 2);
  ASSERT_EQ(apart.captures.size(), 2U);
  EXPECT_EQ(apart.reference_band, "green");
  EXPECT_EQ(apart.captures[0].photos.size(), 5U);
  ASSERT_EQ(flight.photos.size(), 2U);
  EXPECT_EQ(flight.photos[0].name, "SIM_0001_2.TIF");
}

TEST(BandRigTest, TheSameSeedGivesTheSameFilesOnAnyNumberOfThreads) {
  const test::TemporaryFolder one, four;
  SimulateOptions options = SmallRig();
  options.noise_counts = 1.0;
  options.threads = 1;
  Simulate(options, one.path());
  options.threads = 4;
  Simulate(options, four.path());
  for (const char* name : {"photos/SIM_0001_1.TIF", "photos/SIM_0002_5.TIF", "truth/poses.json"})
    EXPECT_TRUE(test::BytesOf(one / name) == test::BytesOf(four / name)) << name;
}

TEST(BandRigTest, OptionsOfPhotosAreRefused) {
  SimulateOptions options = SmallRig();
  EXPECT_TRUE(options.Validate().ok());
  options.vignetting = 0.2;
  EXPECT_FALSE(options.Validate().ok());
}

}  // namespace
}  // namespace skyquilt::simulate
