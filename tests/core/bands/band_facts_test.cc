// What photos of one band say of themselves: makers' spellings, damaged and missing tags.
#include "core/bands/band_facts.h"

#include <gtest/gtest.h>

#include "core/bands/read_radiometry.h"
#include "core/flight/photos/photo_decoder.h"
#include "tests/core/bands/band_photos.h"
#include "tests/support/value_of.h"

namespace skyquilt::bands {
namespace {

Result<BandFacts> Read(const flight::Bytes& bytes) {
  flight::MemoryBytes source(bytes);
  return ReadBandFacts(source);
}

TEST(BandNames, HaveOneSpelling) {
  for (const char* written : {"Red edge", "RedEdge", "Red Edge", "REG"})
    EXPECT_EQ(BandNameOf(written), "rededge") << written;
  EXPECT_EQ(BandNameOf("NIR"), "nir");
  EXPECT_EQ(BandNameOf("Near-Infrared"), "nir");
  EXPECT_EQ(BandNameOf("Red edge-740"), "rededge740");
  EXPECT_EQ(BandNameOf("LWIR"), "lwir");
  EXPECT_EQ(BandNameOf(" ,; "), "");
  EXPECT_LE(BandNameOf(std::string(1 << 20, 'x')).size(), 40U);
}

TEST(BandFacts, OfParrotAndMicaSense) {
  const auto facts = test::ValueOf(Read(BandPhotoBytes(
      "Camera:BandName=\"Red edge\" Camera:CentralWavelength=\"735.0\" Camera:WavelengthFWHM=\"10\" "
      "Camera:CaptureUUID=\"1351F8EE\"")));
  EXPECT_EQ(facts.name, "rededge");
  EXPECT_DOUBLE_EQ(facts.wavelength_nm.value(), 735.0);
  EXPECT_DOUBLE_EQ(facts.width_nm.value(), 10.0);
  EXPECT_EQ(facts.capture_id, "1351F8EE");
  EXPECT_FALSE(facts.is_panel);
}

TEST(BandFacts, OfDji) {
  const auto facts = test::ValueOf(Read(BandPhotoBytes(
      "drone-dji:BandName=\"NIR\" drone-dji:BandFreq=\"840(+/-26)nm\" drone-dji:CaptureUUID=\"abc\"")));
  EXPECT_EQ(facts.name, "nir");
  EXPECT_DOUBLE_EQ(facts.wavelength_nm.value(), 840.0);
  EXPECT_DOUBLE_EQ(facts.width_nm.value(), 52.0);
  EXPECT_EQ(facts.capture_id, "abc");
}

// Their captures are counted, from the start in each flight.
TEST(BandFacts, OfSentera) {
  const auto facts = test::ValueOf(Read(
      BandPhotoBytes("Camera:BandName=\"Blue\" Camera:ImageUniqueID=\"5010\" Camera:RigName=\"Sentera-6x\" "
                     "Camera:FlightUniqueID=\"2020-07-19_17-23-11\"")));
  EXPECT_EQ(facts.capture_id, "2020-07-19_17-23-11 5010");
  EXPECT_EQ(facts.rig, "Sentera-6x");
}

// As Zenmuse XT2 names it.
TEST(BandFacts, OfFlirsOwnTags) {
  const auto facts = test::ValueOf(Read(BandPhotoBytes(
      "xmlns:FLIR=\"http://ns.flir.com/FLIR/1.0/\" FLIR:BandName=\"LWIR\" FLIR:TlinearGain=\"0.04\"")));
  EXPECT_EQ(facts.name, kThermalBand);
  EXPECT_EQ(facts.radiometry.calibration, Calibration::kKelvin);
}

TEST(BandFacts, WithoutABandThereAreNone) {
  const Error facts = test::ErrorOf(Read(BandPhotoBytes("Camera:Yaw=\"1\"")));
  EXPECT_EQ(facts.code, ErrorCode::kUnsupportedFormat);
  EXPECT_NE(facts.message.find("BandName"), std::string::npos);
}

TEST(BandFacts, NumbersThatAreNoneAreLeftOut) {
  const auto facts = test::ValueOf(Read(BandPhotoBytes(
      "Camera:BandName=\"Red\" Camera:CentralWavelength=\"1e300\" Camera:WavelengthFWHM=\"-3\" "
      "drone-dji:BandFreq=\")(nm\" Camera:VignettingPolynomial2DName=\"0,0,99999,0\" "
      "Camera:VignettingPolynomial2D=\"1,2\" Camera:SensorModel=\"0,0,0\" "
      "Camera:IrradianceList=\"####\" drone-dji:SensorGain=\"0\" MicaSense:RadiometricCalibration=\"nan,0,0\"")));
  EXPECT_FALSE(facts.wavelength_nm.has_value());
  EXPECT_FALSE(facts.width_nm.has_value());
  EXPECT_EQ(facts.radiometry.vignetting.kind, BandVignetting::Kind::kNone);
  EXPECT_TRUE(std::isfinite(facts.radiometry.per_level));
}

TEST(BandFacts, CutOffFilesAreRefused) {
  const flight::Bytes whole = BandPhotoBytes("Camera:BandName=\"Red\"");
  for (std::size_t size = 0; size < whole.size(); size += 97) {
    const auto facts = Read({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
    if (facts.ok()) continue;
    EXPECT_FALSE(facts.error().message.empty());
  }
}

TEST(Sunshine, RecordsOfTheSequoia) {
  // Two records: 666 counts at gain 25 in 100 ms, and a saturated one.
  const std::string text = "gwv0DwAAAACaAkAAAQBkAGUzvkFyNqq/RrDoP+ga9w8AAAAA////AAEAZABh6cFBNR8pPwuVFsA";
  const auto records = test::ValueOf(ReadIrradianceList(text));
  ASSERT_EQ(records.size(), 1U);
  EXPECT_NEAR(records.front().time_s, 267.651971, 1e-6);
  EXPECT_NEAR(records.front().counts_per_ms, 666.0 / 100.0 / 25.0, 1e-12);
  EXPECT_NEAR(LastCounts(records), 666.0 / 2500.0, 1e-12);
  EXPECT_FALSE(ReadIrradianceList("").has_value());
  EXPECT_FALSE(ReadIrradianceList("no base64 at all!").has_value());
  EXPECT_FALSE(ReadIrradianceList(std::string(1 << 20, 'A')).has_value());
}

TEST(Sunshine, TheMostSensitiveGainThatIsNotSaturatedCalibrates) {
  const auto counts =
      test::ValueOf(CalibrationCounts("0,600,32,8,1,600,794,209,2,600,13501,3449,3,600,65535,65535"));
  EXPECT_NEAR(counts, 13501.0 / 600.0 / 428.0, 1e-12);
  for (const char* bad : {"", "1,2,3", "9,600,1,1", "-1,600,1,1", "0,0,1,1", "0,600,65535,1", "0.5,600,5,1"})
    EXPECT_FALSE(CalibrationCounts(bad).has_value()) << bad;
}

TEST(SamplePictures, KeepTheirSixteenBits) {
  const flight::Bytes bytes = BandPhotoBytes("Camera:BandName=\"Red\"", UsualExif(), 40'123);
  const auto samples = test::ValueOf(flight::DecodeSampleBytes(bytes, 40, 30));
  ASSERT_EQ(samples.samples.size(), 1200U);
  EXPECT_EQ(samples.samples[777], 40'123);
  EXPECT_EQ(flight::DecodeSampleBytes(bytes, 41, 30).error().code, ErrorCode::kCorrupt);
  EXPECT_FALSE(flight::DecodeSampleBytes({bytes.begin(), bytes.begin() + 300}, 40, 30).ok());
  const flight::Bytes colour = flight::TiffImage({}, 2, 1, {1, 2, 3, 4, 5, 6});
  EXPECT_EQ(flight::DecodeSampleBytes(colour, 2, 1).error().code, ErrorCode::kUnsupportedFormat);
}

}  // namespace
}  // namespace skyquilt::bands
