// Temperatures of thermal pictures: read back to a tenth of a kelvin from files made of known ones, constants
// as ExifTool reads them, and files that are damaged.
#include "core/bands/thermal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/bands/band_facts.h"
#include "core/flight/photos/image_header.h"
#include "core/flight/photos/photo_decoder.h"
#include "core/flight/remarks/because.h"
#include "tests/core/bands/band_photos.h"
#include "tests/core/flight/flir_photo.h"
#include "tests/support/output_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::bands {
namespace {

using flight::Bytes;
using flight::FlirConstants;
using flight::FlirLevels;
using flight::FlirPhoto;
using flight::FlirRecordBytes;
using flight::WithFlirRecord;

constexpr int kThermalWidth = 64, kThermalHeight = 48;

// What a sensor with those constants stores of an object: the light that reaches it, term by term.
double LevelOf(const FlirConstants& c, double object_k) {
  const auto light = [&](double kelvin) {
    return c.planck_r1 / (c.planck_r2 * (std::exp(c.planck_b / kelvin) - c.planck_f));
  };
  const double t = c.atmosphere_k - 273.15;
  const double water =
      c.relative_humidity * std::exp(1.5587 + 6.939e-2 * t - 2.7816e-4 * t * t + 6.8455e-7 * t * t * t);
  const double air =
      c.atmosphere_x * std::exp(-std::sqrt(c.distance_m) * (c.alpha_1 + c.beta_1 * std::sqrt(water))) +
      (1 - c.atmosphere_x) * std::exp(-std::sqrt(c.distance_m) * (c.alpha_2 + c.beta_2 * std::sqrt(water)));
  EXPECT_GT(air, 0.8);
  EXPECT_LT(air, 1.0);
  const double before_window =
      air * (c.emissivity * light(object_k) + (1 - c.emissivity) * light(c.reflected_k)) +
      (1 - air) * light(c.atmosphere_k);
  return c.window_transmission * before_window + (1 - c.window_transmission) * light(c.window_k) - c.planck_o;
}

// From 10 degrees of frost to 80 degrees Celsius.
double TrueKelvin(int x, int y) {
  return 263.15 + 90.0 * (x + kThermalWidth * y) / (kThermalWidth * kThermalHeight - 1.0);
}

Bytes EncodedPng(const std::vector<std::uint16_t>& levels, bool is_swapped) {
  cv::Mat1w picture(kThermalHeight, kThermalWidth);
  for (int i = 0; i < kThermalWidth * kThermalHeight; ++i) {
    const std::uint16_t level = levels[static_cast<std::size_t>(i)];
    picture(i / kThermalWidth, i % kThermalWidth) =
        is_swapped ? static_cast<std::uint16_t>((level << 8) | (level >> 8)) : level;
  }
  Bytes png;
  EXPECT_TRUE(cv::imencode(".png", picture, png));
  return png;
}

FlirPhoto TruePhoto(FlirLevels kind = FlirLevels::kLittleEndian, bool is_swapped = true) {
  FlirPhoto photo;
  photo.constants = flight::UsualFlirConstants();
  photo.width_px = kThermalWidth;
  photo.height_px = kThermalHeight;
  photo.kind = kind;
  for (int y = 0; y < kThermalHeight; ++y) {
    for (int x = 0; x < kThermalWidth; ++x)
      photo.levels.push_back(
          static_cast<std::uint16_t>(std::lround(LevelOf(photo.constants, TrueKelvin(x, y)))));
  }
  if (kind == FlirLevels::kPng) photo.png = EncodedPng(photo.levels, is_swapped);
  return photo;
}

Bytes Jpeg(int width_px = kThermalWidth, int height_px = kThermalHeight) {
  Bytes jpeg;
  EXPECT_TRUE(cv::imencode(".jpg", cv::Mat3b(height_px, width_px, cv::Vec3b(40, 90, 200)), jpeg));
  return jpeg;
}

BandFacts FactsOf(const Bytes& bytes) {
  flight::MemoryBytes source(bytes);
  return test::ValueOf(ReadBandFacts(source));
}

void ExpectTrueKelvins(const Bytes& jpeg, int scale = 1) {
  const BandFacts facts = FactsOf(jpeg);
  EXPECT_EQ(facts.name, "lwir");
  ASSERT_EQ(facts.radiometry.calibration, Calibration::kKelvin) << facts.radiometry.method;
  const auto levels =
      test::ValueOf(flight::DecodeSampleBytes(jpeg, kThermalWidth * scale, kThermalHeight * scale));
  const image::FloatImage kelvins = ValuesOf(levels, facts.radiometry);
  for (int y = 0; y < kThermalHeight; ++y) {
    for (int x = 0; x < kThermalWidth; ++x) {
      const int at = y * scale * kelvins.width_px + x * scale;
      ASSERT_NEAR(kelvins.values[static_cast<std::size_t>(at)], TrueKelvin(x, y), 0.1) << x << " " << y;
    }
  }
}

TEST(FlirTemperatureTest, IsTrueToATenthOfAKelvinInAllWaysToStoreIt) {
  for (const FlirLevels kind : {FlirLevels::kPng, FlirLevels::kLittleEndian, FlirLevels::kBigEndian}) {
    for (const bool is_other : {false, true}) {
      FlirPhoto photo = TruePhoto(kind, is_other);
      photo.is_big_endian = is_other;
      ExpectTrueKelvins(WithFlirRecord(Jpeg(), FlirRecordBytes(photo), is_other ? 1000 : 60'000));
    }
  }
}

TEST(FlirTemperatureTest, LevelsOfAnotherSizeAreBroughtToThePicturesSize) {
  const Bytes jpeg =
      WithFlirRecord(Jpeg(2 * kThermalWidth, 2 * kThermalHeight), FlirRecordBytes(TruePhoto()));
  const auto levels = test::ValueOf(flight::DecodeSampleBytes(jpeg, 2 * kThermalWidth, 2 * kThermalHeight));
  const image::FloatImage kelvins = ValuesOf(levels, FactsOf(jpeg).radiometry);
  // Between four levels, along a row.
  const float between = kelvins.values[static_cast<std::size_t>(20 * 2 * kThermalWidth + 21)];
  EXPECT_NEAR(
      between,
      0.25 * TrueKelvin(10, 9) + 0.75 * TrueKelvin(10, 10) + 0.25 * (TrueKelvin(11, 10) - TrueKelvin(10, 10)),
      0.1);
  const Bytes odd = WithFlirRecord(Jpeg(2 * kThermalWidth, kThermalHeight), FlirRecordBytes(TruePhoto()));
  const auto other = flight::DecodeSampleBytes(odd, 2 * kThermalWidth, kThermalHeight);
  EXPECT_EQ(other.error().code, ErrorCode::kUnsupportedFormat);
  EXPECT_EQ(flight::WhyOf(other.error()), flight::Remark(flight::RemarkCode::kThermalOfOtherShape));
  const auto without = flight::DecodeSampleBytes(Jpeg(), kThermalWidth, kThermalHeight);
  EXPECT_EQ(without.error().code, ErrorCode::kUnsupportedFormat);
  EXPECT_EQ(flight::WhyOf(without.error()), flight::Remark(flight::RemarkCode::kThermalWithoutLevels));
}

TEST(FlirTemperatureTest, EmissivityCounts) {
  FlirPhoto photo = TruePhoto();
  const double level = LevelOf(photo.constants, 320.0);
  EXPECT_NEAR(FlirTemperature(photo.constants)->planck->KelvinOf(level), 320.0, 1e-3);
  photo.constants.emissivity = 1.0;
  EXPECT_LT(FlirTemperature(photo.constants)->planck->KelvinOf(level), 318.5);
}

TEST(FlirTemperatureTest, ConstantsOutOfAllRangeCountAsNotThere) {
  FlirConstants constants = flight::UsualFlirConstants();
  constants.emissivity = -3.0;
  constants.window_transmission = 0.0;
  constants.distance_m = NAN;
  constants.relative_humidity = 1e30;
  const auto radiometry = test::ValueOf(FlirTemperature(constants));
  EXPECT_DOUBLE_EQ(radiometry.planck->object_share, 1.0);
  EXPECT_TRUE(std::isnan(radiometry.planck->KelvinOf(-1e9)));
  for (double FlirConstants::*needed :
       {&FlirConstants::planck_r1, &FlirConstants::planck_r2, &FlirConstants::planck_b}) {
    for (const double wrong : {0.0, -1.0, static_cast<double>(NAN), 1e30}) {
      FlirConstants broken = flight::UsualFlirConstants();
      broken.*needed = wrong;
      EXPECT_FALSE(FlirTemperature(broken).has_value());
    }
  }
}

TEST(FlirTemperatureTest, DamagedRecordsSaySo) {
  const Bytes record = FlirRecordBytes(TruePhoto());
  const auto refused = [](const Bytes& bytes) {
    const auto read = flight::ReadFlirRecord(bytes);
    return !read && read.error().code == ErrorCode::kCorrupt;
  };
  EXPECT_FALSE(refused(record));
  for (const std::size_t length :
       {0UL, 3UL, 0x3FUL, 0x40UL, 0x90UL, 0xA0UL, record.size() / 2, record.size() - 1})
    EXPECT_TRUE(refused(Bytes(record.begin(), record.begin() + static_cast<std::ptrdiff_t>(length))))
        << length;
  for (const std::size_t at :
       {0UL, 0x14UL, 0x18UL, 0x1CUL, 0x40UL + 0x20UL + 0x0CUL, 0x40UL + 0x40UL + 0x10UL}) {
    Bytes broken = record;
    for (std::size_t i = 0; i < 4; ++i) broken[at + i] = 0xFF;
    EXPECT_TRUE(refused(broken)) << at;
  }
  // A segment is missing: the picture stays one, without temperatures.
  Bytes photo = WithFlirRecord(Jpeg(), record, 1000);
  photo[2 + 4 + 6] = 9;
  const BandFacts facts = FactsOf(photo);
  EXPECT_TRUE(facts.is_look_too);
  EXPECT_EQ(facts.radiometry.calibration, Calibration::kLevels);
  EXPECT_EQ(flight::WhyOf(flight::DecodeSampleBytes(photo, kThermalWidth, kThermalHeight).error()),
            flight::Remark(flight::RemarkCode::kTemperaturesDamaged));
  // Levels and a PNG that are not what the record says.
  FlirPhoto wrong = TruePhoto(FlirLevels::kPng);
  wrong.width_px = 63;
  const auto png = WithFlirRecord(Jpeg(), FlirRecordBytes(wrong));
  EXPECT_EQ(flight::WhyOf(flight::DecodeSampleBytes(png, kThermalWidth, kThermalHeight).error()),
            flight::Remark(flight::RemarkCode::kPictureDamaged));
  wrong = TruePhoto();
  wrong.levels.resize(100);
  EXPECT_FALSE(
      flight::DecodeSampleBytes(WithFlirRecord(Jpeg(), FlirRecordBytes(wrong)), kThermalWidth, kThermalHeight)
          .ok());
}

TEST(FlirTemperatureTest, ConstantsAndLevelsAreThoseThatExifToolReads) {
  if (test::OutputOf("exiftool -ver 2>/dev/null").empty()) GTEST_SKIP() << "exiftool is not installed";
  const test::TemporaryFolder folder;
  const FlirPhoto photo = TruePhoto(FlirLevels::kPng);
  const Bytes jpeg = WithFlirRecord(Jpeg(), FlirRecordBytes(photo), 1500);
  const std::string path = folder.Write("thermal.jpg", jpeg).string();
  flight::MemoryBytes source(jpeg);
  const auto header = test::ValueOf(flight::ReadImageHeader(source));
  const auto record = test::ValueOf(flight::ReadFlirRecord(source, header.flir));
  const FlirConstants& c = record.constants;
  constexpr double kZeroCelsiusK = 273.15;
  const std::vector<std::pair<std::string, double>> expected = {
      {"PlanckR1", c.planck_r1},
      {"PlanckR2", c.planck_r2},
      {"PlanckB", c.planck_b},
      {"PlanckF", c.planck_f},
      {"PlanckO", c.planck_o},
      {"Emissivity", c.emissivity},
      {"ObjectDistance", c.distance_m},
      {"ReflectedApparentTemperature", c.reflected_k - kZeroCelsiusK},
      {"AtmosphericTemperature", c.atmosphere_k - kZeroCelsiusK},
      {"IRWindowTemperature", c.window_k - kZeroCelsiusK},
      {"IRWindowTransmission", c.window_transmission},
      {"RelativeHumidity", c.relative_humidity},
      {"AtmosphericTransAlpha1", c.alpha_1},
      {"AtmosphericTransAlpha2", c.alpha_2},
      {"AtmosphericTransBeta1", c.beta_1},
      {"AtmosphericTransBeta2", c.beta_2},
      {"AtmosphericTransX", c.atmosphere_x},
      {"RawThermalImageWidth", record.width_px},
      {"RawThermalImageHeight", record.height_px}};
  for (const auto& [tag, value] : expected) {
    const std::string read = test::OutputOf("exiftool -n -s3 -" + tag + " '" + path + "'");
    ASSERT_FALSE(read.empty()) << tag;
    EXPECT_NEAR(std::stod(read), value, 1e-6 * std::max(1.0, std::abs(value))) << tag;
  }
  const std::string png = test::OutputOf("exiftool -b -RawThermalImage '" + path + "'");
  EXPECT_EQ(Bytes(png.begin(), png.end()), record.picture);
}

Radiometry TiffRadiometry(const std::string& attributes, const std::string& make = "Maker") {
  const Bytes bytes =
      BandPhotoBytes("xmlns:FLIR=\"http://ns.flir.com/FLIR/1.0/\" Camera:BandName=\"LWIR\" " + attributes,
                     UsualExif().Ascii(flight::ExifIfd::kImage, 0x010F, make), 29'315);
  return FactsOf(bytes).radiometry;
}

float FirstKelvin(const Radiometry& radiometry, std::uint16_t level) {
  return ValuesOf({1, 1, {level}}, radiometry).values[0];
}

TEST(LinearTemperatureTest, IsLevelTimesGain) {
  const Radiometry fine = TiffRadiometry("FLIR:TLinearGain=\"0.04\"");
  EXPECT_EQ(fine.calibration, Calibration::kKelvin);
  EXPECT_NEAR(FirstKelvin(fine, 7'329), 293.16, 0.01);
  EXPECT_NEAR(FirstKelvin(TiffRadiometry("FLIR:TlinearGain=\"0.1\""), 2'932), 293.2, 0.01);
  EXPECT_NEAR(FirstKelvin(TiffRadiometry("", "MicaSense"), 29'315), 293.15, 0.01);
}

TEST(LinearTemperatureTest, IsNotGuessed) {
  EXPECT_EQ(TiffRadiometry("").calibration, Calibration::kLevels);
  for (const char* gain : {"0", "-0.04", "nan", "1e9", "x"})
    EXPECT_EQ(TiffRadiometry(fmt::format("FLIR:TLinearGain=\"{}\"", gain)).calibration, Calibration::kLevels)
        << gain;
}

}  // namespace
}  // namespace skyquilt::bands
