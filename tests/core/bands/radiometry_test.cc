// Levels to values of light, each maker's formula against numbers worked out by hand.
#include "core/bands/radiometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/bands/band_facts.h"
#include "tests/core/bands/band_photos.h"

namespace skyquilt::bands {
namespace {

constexpr int kWidth = 40, kHeight = 30;

Radiometry RadiometryOf(const std::string& attributes, const flight::ExifWriter& exif = UsualExif()) {
  const flight::Bytes bytes = BandPhotoBytes("Camera:BandName=\"Red\" " + attributes, exif);
  flight::MemoryBytes source(bytes);
  auto facts = ReadBandFacts(source);
  EXPECT_TRUE(facts.ok());
  return facts->radiometry;
}

float ValueAt(const Radiometry& radiometry, int x, int y, std::uint16_t level = 20'000) {
  const image::SampleImage picture{kWidth, kHeight,
                                   std::vector<std::uint16_t>(std::size_t{kWidth} * kHeight, level)};
  return ValuesOf(picture, radiometry)
      .values[static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x)];
}

TEST(RadiometryOfMicaSense, FollowsTheirModel) {
  const Radiometry radiometry = RadiometryOf(
      "MicaSense:RadiometricCalibration=\"0.00016,1e-7,2e-5\" Camera:VignettingCenter=\"20,15\" "
      "Camera:VignettingPolynomial=\"0.001,0,0,0,0,0\" DLS:HorizontalIrradiance=\"100\"");
  EXPECT_EQ(radiometry.calibration, Calibration::kReflectance);
  const double te = 1.0 / 500.0, y = 3.0, r = std::hypot(4.0 - 20.0, y - 15.0);
  const double radiance = 1.0 / (1.0 + 0.001 * r) * (0.00016 / 2.0) * ((20'000 - 4800) / 65536.0) /
                          (te + 1e-7 * y - 2e-5 * te * y);
  // Vignetting is read off nodes every 16 pixels, which a cusp at its middle shows.
  EXPECT_NEAR(ValueAt(radiometry, 4, 3), std::numbers::pi * radiance / 1.0, 5e-3 * radiance);
}

TEST(RadiometryOfMicaSense, WithoutLightSensorIsRadiance) {
  const Radiometry radiometry = RadiometryOf("MicaSense:RadiometricCalibration=\"0.00016,0,0\"");
  EXPECT_EQ(radiometry.calibration, Calibration::kRadiance);
  EXPECT_NEAR(ValueAt(radiometry, 0, 0), 0.00008 * (15'200 / 65536.0) * 500.0, 1e-9);
}

flight::ExifWriter MicaSenseExif(const std::string& model, const std::string& software) {
  return UsualExif()
      .Ascii(flight::ExifIfd::kImage, 0x0110, model)
      .Ascii(flight::ExifIfd::kImage, 0x0131, software);
}

TEST(RadiometryOfMicaSense, TheGainIsTheIsoSpeed) {
  constexpr std::uint16_t kIsoSpeed = 0x8833;
  const std::string calibration = "MicaSense:RadiometricCalibration=\"0.00016,0,0\"";
  const Radiometry of_two = RadiometryOf(calibration);  // ISO 200
  const Radiometry of_eight =
      RadiometryOf(calibration, UsualExif().Long(flight::ExifIfd::kExif, kIsoSpeed, 800));
  EXPECT_NEAR(ValueAt(of_eight, 0, 0), ValueAt(of_two, 0, 0) / 4.0F, 1e-6);
}

TEST(RadiometryOfMicaSense, AnExposureTimeThatEarlyFirmwaresWroteWronglyIsRight) {
  const auto exposed = [](const std::string& model, std::uint32_t one_over) {
    const auto exif =
        MicaSenseExif(model, "v2.1.0").Rational(flight::ExifIfd::kExif, kExposureTime, {{1, one_over}});
    return RadiometryOf("MicaSense:RadiometricCalibration=\"0.00016,0,0\"", exif).rows.exposure_s;
  };
  EXPECT_DOUBLE_EQ(exposed("RedEdge", 6329), 0.000274);
  EXPECT_DOUBLE_EQ(exposed("RedEdge-M", 6329), 0.000274);
  EXPECT_DOUBLE_EQ(exposed("RedEdge", 6300), 1.0 / 6300.0);
  EXPECT_DOUBLE_EQ(exposed("Altum", 6329), 1.0 / 6329.0);
}

TEST(RadiometryOfMicaSense, IrradianceOfAFirmwareThatLevelsItWronglyIsTheSensorsOwn) {
  const auto scaled = [](const std::string& model, const std::string& software, const std::string& tags) {
    const Radiometry radiometry = RadiometryOf("MicaSense:RadiometricCalibration=\"0.00016,0,0\" " + tags,
                                               MicaSenseExif(model, software));
    EXPECT_EQ(radiometry.calibration, Calibration::kReflectance);
    return std::numbers::pi * 0.00008 / 65536.0 / radiometry.per_level;  // W/m^2/nm
  };
  const std::string both = "DLS:HorizontalIrradiance=\"100\" DLS:SpectralIrradiance=\"80\" ";
  EXPECT_NEAR(scaled("RedEdge-M", "v5.1.6", both), 0.8, 1e-9);
  EXPECT_NEAR(scaled("RedEdge-M", "v5.1.7", both), 1.0, 1e-9);
  EXPECT_NEAR(scaled("RedEdge-M", "v10.0.0", both), 1.0, 1e-9);
  EXPECT_NEAR(scaled("Altum", "v1.2.2", both), 0.8, 1e-9);
  EXPECT_NEAR(scaled("Altum-PT", "v1.0.0", both), 1.0, 1e-9);
  EXPECT_NEAR(scaled("RedEdge-P", "", both), 1.0, 1e-9);
  // The first light sensor counts in SI units, the second says its own.
  EXPECT_NEAR(scaled("RedEdge", "v3.3.0", "DLS:SpectralIrradiance=\"1.1\""), 1.1, 1e-9);
  EXPECT_NEAR(
      scaled("RedEdge", "v7.0.0", "DLS:SpectralIrradiance=\"80\" Camera:IrradianceScaleToSIUnits=\"0.02\""),
      1.6, 1e-9);
}

TEST(RadiometryOfDji, FollowsTheirGuide) {
  const Radiometry radiometry = RadiometryOf(
      "drone-dji:SensorGain=\"2\" drone-dji:ExposureTime=\"1000\" drone-dji:SensorGainAdjustment=\"0.5\" "
      "drone-dji:Irradiance=\"4000\" drone-dji:VignettingData=\"0,0.0001,0,0,0,0\" "
      "drone-dji:CalibratedOpticalCenterX=\"16\" drone-dji:CalibratedOpticalCenterY=\"16\"");
  EXPECT_EQ(radiometry.calibration, Calibration::kRelative);
  const double camera = (20'000 - 4800) / 65535.0 / (2.0 * 1000e-6);
  EXPECT_NEAR(ValueAt(radiometry, 16, 16), camera * 0.5 / 4000.0, 1e-6 * camera);
  EXPECT_NEAR(ValueAt(radiometry, 32, 16) / ValueAt(radiometry, 16, 16), 1.0 + 0.0001 * 256.0, 1e-5);
}

TEST(RadiometryOfDji, ALightSensorThatIsCoveredIsNotBelieved) {
  const auto radiometry = [](const char* status) {
    return RadiometryOf(
        "drone-dji:SensorGain=\"2\" drone-dji:ExposureTime=\"1000\" drone-dji:SensorGainAdjustment=\"0.5\" "
        "drone-dji:Irradiance=\"4000\" drone-dji:LS_status=\"" +
        std::string(status) + "\"");
  };
  EXPECT_EQ(radiometry("0").calibration, Calibration::kRadiance);
  EXPECT_FALSE(radiometry("0").sunlight);
  EXPECT_EQ(radiometry("1").calibration, Calibration::kRelative);
  EXPECT_EQ(radiometry("2").calibration, Calibration::kRelative);
}

TEST(RadiometryOfDji, TheBlackLevelMayStandAmongTheMakersTags) {
  const Radiometry radiometry = RadiometryOf(
      "drone-dji:BlackCurrent=\"3200\" drone-dji:SensorGain=\"1\" drone-dji:ExposureTime=\"1000\"",
      flight::ExifWriter());
  EXPECT_NEAR(ValueAt(radiometry, 0, 0), (20'000 - 3200) / 65535.0 / 1e-3, 1e-2);
}

// As a Mavic 3 Multispectral writes it; one of 16 bits is left over from what the file was made of.
TEST(RadiometryOfDji, TheBlackLevelOfEightBitsIsOneOfThem) {
  const auto black = [](const std::string& level) {
    const flight::Bytes bytes = flight::TiffImage(
        flight::ExifWriter(), kWidth, kHeight, flight::Bytes(std::size_t{3} * kWidth * kHeight, 80),
        flight::XmpPacket(std::string(kCameraXmp) + flight::kDjiNamespace +
                          "Camera:BandName=\"Red\" drone-dji:BlackCurrent=\"" + level +
                          "\" drone-dji:SensorGain=\"1\" drone-dji:ExposureTime=\"1000\""));
    flight::MemoryBytes source(bytes);
    const auto facts = ReadBandFacts(source);
    return facts ? facts->radiometry.black[3] : -1.0;
  };
  EXPECT_DOUBLE_EQ(black("12"), 12.0 * 257.0);
  EXPECT_DOUBLE_EQ(black("3200"), 3200.0);
}

TEST(RadiometryOfSequoia, ByTheFactorysMeasurement) {
  // 15 200 levels above black at ISO 200 and 1/500 s; the factory saw 345 levels of 10 bits at 1/200 s, and
  // ten times less light at the sunshine sensor.
  const Radiometry radiometry = RadiometryOf(
      "Camera:CalibrationMeasurement=\"1,0.005,420\" Camera:BlackCurrent=\"75\" "
      "Camera:IrradianceCalibrationMeasurement=\"1,100,66.6,1\" "
      "Camera:IrradianceList=\"gwv0DwAAAACaAkAAAQBkAGUzvkFyNqq/RrDoPw==\" "
      "Camera:VignettingPolynomial2DName=\"0,0,1,0\" Camera:VignettingPolynomial2D=\"0.5,0.5\"");
  EXPECT_EQ(radiometry.calibration, Calibration::kRelative);
  const double rate = 15'200.0 / (2.0 / 500.0), factory = 345.0 * 64.0 / 0.005;
  EXPECT_NEAR(ValueAt(radiometry, 0, 0), rate / factory / 10.0 / 0.5, 1e-5);
  EXPECT_NEAR(ValueAt(radiometry, 32, 0), rate / factory / 10.0 / (0.5 + 0.5 * 32.0 / 40.0), 1e-5);
}

TEST(RadiometryOfSequoia, WithoutATagOfTheTiffTheBlackLevelIsOfTenBits) {
  const auto exif = flight::ExifWriter()
                        .Rational(flight::ExifIfd::kExif, kExposureTime, {{1, 500}})
                        .Short(flight::ExifIfd::kExif, kIso, 200);
  const Radiometry radiometry =
      RadiometryOf("Camera:CalibrationMeasurement=\"1,0.005,420\" Camera:BlackCurrent=\"75\"", exif);
  EXPECT_NEAR(ValueAt(radiometry, 0, 0), (20'000 - 75 * 64) / 65536.0 / (2.0 / 500.0), 1e-2);
}

TEST(RadiometryOfSequoia, BySensorModelIsUpToAFactor) {
  const Radiometry radiometry = RadiometryOf("Camera:SensorModel=\"5000,4000,16\"");
  EXPECT_EQ(radiometry.calibration, Calibration::kRadiance);
  const double iso = 200.0, exposure_s = 1.0 / 500.0;
  EXPECT_NEAR(ValueAt(radiometry, 0, 0), 16'000.0 / (5000.0 * exposure_s * iso + 16.0), 1e-3);
}

TEST(RadiometryOfOthers, TakesExposureWhereThereIsOne) {
  EXPECT_EQ(RadiometryOf("").calibration, Calibration::kRadiance);
  const Radiometry bare = RadiometryOf("", flight::ExifWriter());
  EXPECT_EQ(bare.calibration, Calibration::kLevels);
  EXPECT_NEAR(ValueAt(bare, 5, 5), 20'000 / 65536.0, 1e-6);
}

TEST(RadiometryOfOthers, APolynomialThatIsNoneNeitherDarkensNorBlinds) {
  Radiometry radiometry;
  radiometry.vignetting.kind = BandVignetting::Kind::kRadialDivides;
  for (const double k : {-1e9, 1e9, std::nan("")}) {
    radiometry.vignetting.radial = {k, k};
    for (const int x : {0, 20, 39}) {
      const float value = ValueAt(radiometry, x, 29);
      EXPECT_GE(value, 2000.0F * 0.99F);
      EXPECT_LE(value, 200'000.0F * 1.01F);
    }
  }
}

TEST(RadiometryOfOthers, BlackIsOfTheSensorsPattern) {
  Radiometry radiometry;
  radiometry.black = {1.0, 2.0, 3.0, 4.0};
  EXPECT_FLOAT_EQ(ValueAt(radiometry, 0, 0, 100), 99.0F);
  EXPECT_FLOAT_EQ(ValueAt(radiometry, 1, 0, 100), 98.0F);
  EXPECT_FLOAT_EQ(ValueAt(radiometry, 0, 1, 100), 97.0F);
  EXPECT_FLOAT_EQ(ValueAt(radiometry, 3, 5, 100), 96.0F);
}

}  // namespace
}  // namespace skyquilt::bands
