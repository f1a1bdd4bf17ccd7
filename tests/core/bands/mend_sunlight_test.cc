// Readings of the light sensor that stand alone.
#include "core/bands/mend_sunlight.h"

#include <gmock/gmock.h>

#include <chrono>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::bands {
namespace {

// Captures of one band, two seconds apart, whose values were divided by these readings.
Captures Under(const std::vector<double>& sunlight) {
  Captures captures;
  captures.bands = {{"red", 660.0, {}, Calibration::kReflectance, "by Maker"}};
  for (const double reading : sunlight) {
    BandPhoto photo;
    photo.photo.captured_at =
        flight::UtcTime(std::chrono::hours(24 * 19'000)) + std::chrono::seconds(2 * captures.captures.size());
    photo.facts.name = "red";
    photo.facts.radiometry.per_level = 1.0 / reading;
    photo.facts.radiometry.sunlight = reading;
    captures.captures.emplace_back().photos.push_back(photo);
  }
  return captures;
}

double DividedBy(const Captures& captures, std::size_t capture) {
  return 1.0 / captures.captures[capture].photos[0].facts.radiometry.per_level;
}

TEST(MendSunlight, AReadingFarOffItsNeighboursGivesWayToThem) {
  for (const double odd : {0.25, 2.5}) {
    Captures captures = Under({1.0, 1.0, odd, 1.0, 1.0});
    std::vector<flight::Remark> warnings;
    MendSunlight(captures, warnings);
    for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(DividedBy(captures, i), 1.0, 1e-12) << odd << " " << i;
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_THAT(InWords(warnings[0]), testing::HasSubstr(odd < 1.0 ? "4.0 times" : "2.5 times"));
  }
}

TEST(MendSunlight, LightThatChangesStaysAsItWasMeasured) {
  for (const std::vector<double>& sunlight :
       {std::vector{1.0, 1.0, 0.4, 0.4, 0.4, 1.0}, std::vector{1.0, 0.55, 1.0}, std::vector{1.0, 0.3, 0.8},
        std::vector{3.0, 1.0, 1.0}, std::vector{1.0, 1.0, 3.0, 1.0, 3.0, 1.0, 1.0}, std::vector{1.0}}) {
    Captures captures = Under(sunlight);
    std::vector<flight::Remark> warnings;
    MendSunlight(captures, warnings);
    for (std::size_t i = 0; i < sunlight.size(); ++i)
      EXPECT_NEAR(DividedBy(captures, i), sunlight[i], 1e-12) << i;
    EXPECT_TRUE(warnings.empty());
  }
}

TEST(MendSunlight, NeighboursAreOfTheSameMoments) {
  const std::vector<double> sunlight{1.0, 3.0, 1.0};
  std::vector<flight::Remark> warnings;
  Captures later = Under(sunlight);
  *later.captures[2].photos[0].photo.captured_at += std::chrono::seconds(30);
  MendSunlight(later, warnings);
  EXPECT_NEAR(DividedBy(later, 1), 3.0, 1e-12);
  Captures without_clock = Under(sunlight);
  without_clock.captures[0].photos[0].photo.captured_at.reset();
  MendSunlight(without_clock, warnings);
  EXPECT_NEAR(DividedBy(without_clock, 1), 3.0, 1e-12);
  Captures of_others = Under(sunlight);
  of_others.captures[1].photos[0].photo.camera_key = "another";
  MendSunlight(of_others, warnings);
  EXPECT_NEAR(DividedBy(of_others, 1), 3.0, 1e-12);
  EXPECT_TRUE(warnings.empty());
}

}  // namespace
}  // namespace skyquilt::bands
