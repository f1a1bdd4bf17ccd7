// Calibration panels: what their codes say, where they stand in a picture, and which factors follow.
#include <gmock/gmock.h>

#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>
#include <tuple>
#include <utility>

#include "core/bands/calibrate_by_panels.h"
#include "core/bands/find_panel.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/support/value_of.h"

namespace skyquilt::bands {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;
using ::testing::SizeIs;

// "RP04-1924106-OB04005250900524" as QR code.
constexpr std::array<std::string_view, 25> kCode = {
    "#######.#...##.##.#######", "#.....#.#####...#.#.....#", "#.###.#....#.#..#.#.###.#",
    "#.###.#.#.###..#..#.###.#", "#.###.#...###.#...#.###.#", "#.....#..##.##....#.....#",
    "#######.#.#.#.#.#.#######", "........##..#.#.#........", "#.##.###.#####.#..#..#.##",
    ".##.#..##.##.#..##...##.#", "#...####..#.##.##..###.#.", "####.#.##..#....#...##...",
    ".#....#.#..##.###..#.#..#", ".#..##.##.###.#.#.##.###.", ".####.#..###.#.##..#.##.#",
    "#.#..#..##.#..##.##..####", "..#..##.....#.#.#####...#", "........#.....#.#...##...",
    "#######.###..####.#.##.#.", "#.....#.##.#.##.#...#.#.#", "#.###.#......#########.#.",
    "#.###.#.##.....##.#..##.#", "#.###.#.#.#...#..#..#..#.", "#.....#..#.####.#.......#",
    "#######.####...###.#..#.#",
};

TEST(PanelCode, SaysSerialAndReflectance) {
  const auto code = test::ValueOf(ParsePanelCode("RP04-1924106-OB04005250900425"));
  EXPECT_EQ(code.serial, "RP04-1924106-OB");
  EXPECT_EQ(code.version, 4);
  EXPECT_DOUBLE_EQ(*code.ReflectanceAt(400.0), 0.525);
  EXPECT_DOUBLE_EQ(*code.ReflectanceAt(650.0), 0.475);
  EXPECT_DOUBLE_EQ(*code.ReflectanceAt(2000.0), 0.425) << "no further than it was measured";
  const auto old = test::ValueOf(ParsePanelCode("RP02-1603036-SC"));
  EXPECT_EQ(old.version, 2);
  EXPECT_FALSE(old.ReflectanceAt(560.0));
}

TEST(PanelCode, OfAnythingElseIsNone) {
  for (const char* text :
       {"", "https://example.org", "RP04", "RPxx-1924106-OB", "RP04-192410x-OB", "RP04 1924106 OB"})
    EXPECT_FALSE(ParsePanelCode(text)) << text;
  for (const char* text :
       {"RP04-1924106-OB0400525", "RP04-1924106-OB09005250400524", "RP04-1924106-OB0400000090000x"}) {
    const auto code = ParsePanelCode(text);
    ASSERT_TRUE(code) << text;
    EXPECT_FALSE(code->ReflectanceAt(560.0)) << text;
  }
}

// A panel seen from above on ground of level `ground`: its grey square, the code beside it at `side_px`, the
// whole turned about the picture's middle.
constexpr int kPanelPhotoWidth = 640, kPanelPhotoHeight = 480;
struct PanelScene {
  double side_px = 120.0;
  double turn_rad = 0.0;
  std::uint16_t grey = 30'000, ground = 9'000;
};
image::SampleImage Draw(const PanelScene& scene) {
  image::SampleImage picture{kPanelPhotoWidth, kPanelPhotoHeight, {}};
  const double c = std::cos(scene.turn_rad), s = std::sin(scene.turn_rad);
  for (int y = 0; y < kPanelPhotoHeight; ++y) {
    for (int x = 0; x < kPanelPhotoWidth; ++x) {
      const double ground = scene.ground + 700.0 * std::sin(x * 0.9) * std::cos(y * 0.7);
      double sum = 0.0;
      constexpr int kOver = 3;
      for (int k = 0; k < kOver * kOver; ++k) {
        const double dx = x + (k % kOver + 0.5) / kOver - kPanelPhotoWidth / 2.0,
                     dy = y + (k / kOver + 0.5) / kOver - kPanelPhotoHeight / 2.0;
        // In sides of the code, from the middle between code and square; the code is on the right.
        const Vector2d at = Vector2d(c * dx + s * dy, -s * dx + c * dy) / scene.side_px;
        const Vector2d in_code = at - Vector2d(0.775, 0.0), in_square = at + Vector2d(0.775, 0.0);
        double level = ground;
        if (in_code.cwiseAbs().maxCoeff() < 0.66) {
          level = 55'000.0;
          if (in_code.cwiseAbs().maxCoeff() < 0.5) {
            const int column = static_cast<int>((in_code.x() + 0.5) * 25.0),
                      row = static_cast<int>((in_code.y() + 0.5) * 25.0);
            if (kCode[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] == '#')
              level = 4'000.0;
          }
        } else if (in_square.cwiseAbs().maxCoeff() < 0.4) {
          level = scene.grey;
        }
        sum += level;
      }
      picture.samples.push_back(static_cast<std::uint16_t>(sum / 9.0));
    }
  }
  return picture;
}

TEST(FindPanel, FindsTheGreySquareHoweverThePanelIsTurned) {
  for (const double turn_rad : {0.0, 0.3, 1.2, 1.57, 2.6, 3.14, -1.8}) {
    const image::SampleImage picture = Draw({.turn_rad = turn_rad});
    const auto found = FindPanel(picture);
    ASSERT_TRUE(found) << turn_rad;
    EXPECT_EQ(found->code.serial, "RP04-1924106-OB");
    const auto levels = test::ValueOf(LevelsIn(picture, found->area_px));
    EXPECT_EQ(levels.median, 30'000.0) << turn_rad;
    EXPECT_LT(levels.spread, 0.01) << turn_rad << ": the square alone";
    EXPECT_EQ(levels.clipped_share, 0.0);
  }
}

TEST(FindPanel, FindsNoneWhereThereIsNone) {
  EXPECT_FALSE(FindPanel({}));
  EXPECT_FALSE(FindPanel({1, 1, {7}}));
  EXPECT_FALSE(FindPanel({64, 64, std::vector<std::uint16_t>(64 * 64, 0)}));
  EXPECT_FALSE(FindPanel({64, 64, std::vector<std::uint16_t>(64 * 64, 65'535)}));
  image::SampleImage stripes{200, 3000, {}};
  for (int i = 0; i < 200 * 3000; ++i) stripes.samples.push_back(static_cast<std::uint16_t>(i * 7919));
  EXPECT_FALSE(FindPanel(stripes));
  EXPECT_FALSE(FindPanel(Draw({.side_px = 25.0}))) << "too small to be read";
}

TEST(FindPanel, AreasBeyondThePictureOrWithoutPixelsHaveNoLevels) {
  const image::SampleImage picture{100, 80, std::vector<std::uint16_t>(8000, 5)};
  const auto box = [](double left, double top, double right, double bottom) {
    return PanelArea{Vector2d(left, top), Vector2d(right, top), Vector2d(right, bottom),
                     Vector2d(left, bottom)};
  };
  EXPECT_TRUE(LevelsIn(picture, box(10, 10, 20, 20)));
  EXPECT_FALSE(LevelsIn(picture, box(-1, 10, 20, 20)));
  EXPECT_FALSE(LevelsIn(picture, box(10, 10, 20, 80)));
  EXPECT_FALSE(LevelsIn(picture, box(10, 10, 12, 12))) << "nine pixels";
  EXPECT_FALSE(LevelsIn(picture, box(10, 10, 1e300, 20)));
  EXPECT_FALSE(LevelsIn(picture, box(10, 10, std::nan(""), 20)));
  EXPECT_FALSE(LevelsIn(picture, {Vector2d(10, 10), Vector2d(30, 30), Vector2d(30, 10), Vector2d(10, 30)}))
      << "crossed";
}

// Pictures by the names of their photos.
class Drawn final : public flight::PhotoSource {
 public:
  Result<image::DecodedImage> Decode(const flight::Photo&, int) const override {
    return Error{ErrorCode::kUnsupportedFormat, "in bands alone", ""};
  }
  Result<image::SampleImage> DecodeSamples(const flight::Photo& photo) const override {
    ++decoded;
    const auto found = pictures.find(photo.name);
    if (found == pictures.end()) return Error{ErrorCode::kCorrupt, "The picture is damaged.", ""};
    return found->second;
  }
  std::map<std::string, image::SampleImage> pictures;
  mutable int decoded = 0;
};

// Eight captures of red and nir, whose values are levels above 1000 as a share of 50000; the second shows a
// panel.
class CalibrateByPanelsTest : public testing::Test {
 protected:
  CalibrateByPanelsTest() {
    captures_.reference_band = "red";
    captures_.bands = {{"red", 660.0, {}, Calibration::kRelative, "by Maker"},
                       {"nir", 790.0, {}, Calibration::kRelative, "by Maker"}};
    static const image::SampleImage none_readable = Draw({.side_px = 20.0});
    for (int i = 0; i < 8; ++i) {
      Capture& capture = captures_.captures.emplace_back();
      for (const Band& band : captures_.bands) {
        BandPhoto photo;
        photo.photo.name = std::to_string(i) + "_" + band.name + ".tif";
        photo.facts.name = band.name;
        photo.facts.wavelength_nm = band.wavelength_nm;
        photo.facts.radiometry.per_level = 1.0 / 50'000.0;
        photo.facts.radiometry.black.fill(1000.0);
        photo.facts.radiometry.calibration = Calibration::kRelative;
        source_.pictures[photo.photo.name] = none_readable;
        capture.photos.push_back(photo);
      }
      capture.reference = capture.photos.front().photo.name;
      flight_.photos.push_back(capture.photos.front().photo);
    }
    static const image::SampleImage red = Draw({.grey = 26'000});
    static const image::SampleImage nir = Draw({.turn_rad = 0.2, .grey = 51'000});
    source_.pictures["1_red.tif"] = red;
    source_.pictures["1_nir.tif"] = nir;
  }
  // What the code's 0.5246 or so at the band's wavelength makes of a value of 0.5 (red) and 1 (nir).
  static constexpr double kRed = 0.525 - 0.001 * 260.0 / 500.0, kNir = 0.525 - 0.001 * 390.0 / 500.0;
  double FactorOf(const std::string& band) const {
    for (const BandPhoto& photo : captures_.captures.back().photos) {
      if (photo.facts.name == band) return photo.facts.radiometry.per_level * 50'000.0;
    }
    return std::numeric_limits<double>::quiet_NaN();
  }
  // As a list names the photo, or the camera marked it.
  void PutApart(std::size_t capture) {
    for (BandPhoto& photo : captures_.captures[capture].photos) captures_.panels.push_back(photo);
    captures_.captures.erase(captures_.captures.begin() + static_cast<std::ptrdiff_t>(capture));
    flight_.photos.erase(flight_.photos.begin() + static_cast<std::ptrdiff_t>(capture));
  }
  // The captures follow each other by the minute.
  static void TakePanelsBefore(int hours, Captures& captures) {
    const flight::UtcTime first(std::chrono::hours(24 * 19'000 + 12));
    for (std::size_t i = 0; i < captures.captures.size(); ++i) {
      for (BandPhoto& photo : captures.captures[i].photos)
        photo.photo.captured_at = first + std::chrono::minutes(i);
    }
    for (BandPhoto& panel : captures.panels) panel.photo.captured_at = first - std::chrono::hours(hours);
  }
  flight::Flight flight_;
  Captures captures_;
  Drawn source_;
};

TEST_F(CalibrateByPanelsTest, APanelAmongTheFirstCapturesIsFoundByItsCode) {
  CalibrateByPanels(flight_, captures_, source_);
  EXPECT_NEAR(FactorOf("red"), kRed / 0.5, 1e-6);
  EXPECT_NEAR(FactorOf("nir"), kNir / 1.0, 1e-6);
  EXPECT_THAT(captures_.captures, SizeIs(7));
  EXPECT_THAT(flight_.photos, SizeIs(7)) << "its reference is no photo of the ground";
  ASSERT_THAT(flight_.left_out, SizeIs(2));
  EXPECT_THAT(InWords(flight_.left_out[0].reason), HasSubstr("calibration panel"));
  EXPECT_TRUE(flight_.warnings.empty());
  EXPECT_EQ(captures_.bands[0].calibration, Calibration::kReflectance);
  EXPECT_EQ(captures_.bands[0].method, "by Maker, by 1 picture of RP04-1924106-OB");
}

TEST_F(CalibrateByPanelsTest, AsManyAsFollowEachOtherAreFound) {
  for (const char* capture : {"0", "2", "3"}) {
    for (const char* band : {"_red.tif", "_nir.tif"})
      source_.pictures[std::string(capture) + band] = source_.pictures[std::string("1") + band];
  }
  CalibrateByPanels(flight_, captures_, source_);
  EXPECT_THAT(captures_.captures, SizeIs(4));
  EXPECT_THAT(flight_.photos, SizeIs(4));
  EXPECT_NEAR(FactorOf("red"), kRed / 0.5, 1e-6);
}

TEST_F(CalibrateByPanelsTest, OneThatTheCameraMarkedDoesNotHideAnother) {
  PutApart(1);
  for (const char* band : {"_red.tif", "_nir.tif"})
    source_.pictures[std::string("7") + band] = source_.pictures[std::string("1") + band];
  CalibrateByPanels(flight_, captures_, source_);
  EXPECT_THAT(captures_.captures, SizeIs(6));
  EXPECT_THAT(flight_.photos, SizeIs(6));
  EXPECT_THAT(captures_.panels, SizeIs(4));
}

TEST_F(CalibrateByPanelsTest, OneInTheMiddleOfTheFlightIsNotLookedFor) {
  std::swap(source_.pictures["1_red.tif"], source_.pictures["4_red.tif"]);
  CalibrateByPanels(flight_, captures_, source_);
  EXPECT_EQ(FactorOf("red"), 1.0);
  EXPECT_EQ(source_.decoded, 4);
  EXPECT_EQ(captures_.bands[0].calibration, Calibration::kRelative);
}

TEST_F(CalibrateByPanelsTest, WhereAllShowOneNoneIsTaken) {
  captures_.captures.resize(1);
  flight_.photos.resize(1);
  source_.pictures["0_red.tif"] = Draw({});
  CalibrateByPanels(flight_, captures_, source_);
  EXPECT_THAT(captures_.captures, SizeIs(1));
  EXPECT_THAT(flight_.photos, SizeIs(1));
  EXPECT_EQ(FactorOf("red"), 1.0);
  ASSERT_THAT(flight_.warnings, SizeIs(1));
}

TEST_F(CalibrateByPanelsTest, WhatTheCameraWroteDownCounts) {
  source_.pictures["1_red.tif"] = {
      kPanelPhotoWidth, kPanelPhotoHeight,
      std::vector<std::uint16_t>(std::size_t{kPanelPhotoWidth} * kPanelPhotoHeight, 21'000)};
  PutApart(1);
  PanelTags& tags = captures_.panels[0].facts.panel;
  tags = {std::array<double, 8>{10, 10, 60, 10, 60, 60, 10, 60}, 0.6, "RP06-0000001-OB"};
  CalibrateByPanels(flight_, captures_, source_);
  EXPECT_NEAR(FactorOf("red"), 0.6 / 0.4, 1e-6);
  EXPECT_NEAR(FactorOf("nir"), kNir, 1e-6) << "without tags its code is read";
  EXPECT_THAT(captures_.bands[0].method, HasSubstr("RP06-0000001-OB"));
}

TEST_F(CalibrateByPanelsTest, AListTellsWhereAPanelIsAndHowBright) {
  PutApart(1);
  flight::ReflectanceList list;
  list.panels.push_back({"1_RED.TIF", std::array<double, 4>{190, 215, 250, 265}, {0.7, {}}});
  list.panels.push_back({"1_nir.tif", std::nullopt, {{}, {{"near infrared", 0.4}}}});
  flight_.reflectance_lists = {list};
  CalibrateByPanels(flight_, captures_, source_);
  EXPECT_NEAR(FactorOf("red"), 0.7 / 0.5, 1e-6);
  EXPECT_NEAR(FactorOf("nir"), 0.4, 1e-6);
  EXPECT_TRUE(flight_.warnings.empty());
}

TEST_F(CalibrateByPanelsTest, PicturesThatCannotBeUsedAreTold) {
  PutApart(1);
  const auto told = [&](image::SampleImage red) {
    flight::Flight flight = flight_;
    Captures captures = captures_;
    source_.pictures["1_red.tif"] = std::move(red);
    CalibrateByPanels(flight, captures, source_);
    EXPECT_EQ(captures.captures.back().photos[0].facts.radiometry.per_level, 1.0 / 50'000.0);
    EXPECT_THAT(flight.warnings, SizeIs(1));
    EXPECT_THAT(InWords(test::ValueOf(BandsHeldAgainstNothing(captures))), HasSubstr("for red:"));
    return InWords(flight.warnings.front());
  };
  EXPECT_THAT(told(Draw({.side_px = 20.0})), HasSubstr("1_red.tif: no code of a panel can be read"));
  EXPECT_THAT(told(Draw({.grey = 65'400})), HasSubstr("overexposed"));
  EXPECT_THAT(told(Draw({.grey = 900})), HasSubstr("black"));
  source_.pictures.erase("1_red.tif");
  captures_.panels[0].facts.radiometry.calibration = Calibration::kLevels;
  EXPECT_THAT(told(Draw({})), HasSubstr("how it was exposed"));
  // Its factor would hold for radiance alone.
  captures_.panels[0].facts.radiometry.calibration = Calibration::kRadiance;
  EXPECT_THAT(told(Draw({})),
              HasSubstr("its values are radiance, those of the photos of the ground relative"));
}

TEST_F(CalibrateByPanelsTest, BandsThatNothingKnownTellsOfAreNamedWhereOthersAreTold) {
  EXPECT_FALSE(BandsHeldAgainstNothing(captures_)) << "values of all bands are as their light has them";
  std::vector<flight::Remark> warnings;
  ScaleBand(captures_, "red", {.by_group = {{"", std::vector<double>{1.2}}}}, HeldAgainst::kTargets,
            "by 1 target", warnings);
  EXPECT_THAT(InWords(test::ValueOf(BandsHeldAgainstNothing(captures_))), HasSubstr("for nir:"));
  captures_.bands[1].calibration = Calibration::kKelvin;
  EXPECT_FALSE(BandsHeldAgainstNothing(captures_)) << "temperatures need nothing known";
}

TEST_F(CalibrateByPanelsTest, APanelFarFromTheFlightIsUsedAndSaidUnlessALightSensorTells) {
  using std::tuple;
  for (const auto& [hours, values, is_told] :
       {tuple{1, Calibration::kRadiance, false}, tuple{3, Calibration::kRadiance, true},
        tuple{24, Calibration::kRadiance, true}, tuple{24, Calibration::kRelative, false}}) {
    flight::Flight flight = flight_;
    Captures captures = captures_;
    SetPanelsApart({false, true, false, false, false, false, false, false}, captures, flight);
    for (Band& band : captures.bands) band.calibration = values;
    for (BandPhoto& panel : captures.panels) panel.facts.radiometry.calibration = values;
    TakePanelsBefore(hours, captures);
    CalibrateByPanels(flight, captures, source_);
    EXPECT_NEAR(captures.captures.back().photos[0].facts.radiometry.per_level, kRed / 0.5 / 50'000.0, 1e-9);
    ASSERT_THAT(flight.warnings, SizeIs(is_told ? 1 : 0)) << hours;
    if (is_told) {
      EXPECT_THAT(InWords(flight.warnings[0]), HasSubstr(std::to_string(hours) + " hours"));
    }
  }
}

TEST_F(CalibrateByPanelsTest, APanelOfAnotherDayIsNotUsedBesideOneOfTheFlights) {
  PutApart(1);
  captures_.panels.pop_back();  // that of nir
  TakePanelsBefore(24, captures_);
  captures_.panels.push_back(captures_.panels[0]);
  captures_.panels.back().photo.name = "second.tif";
  *captures_.panels.back().photo.captured_at += std::chrono::hours(23);
  source_.pictures["second.tif"] = Draw({.grey = 16'000});
  CalibrateByPanels(flight_, captures_, source_);
  EXPECT_NEAR(FactorOf("red"), kRed / 0.3, 1e-6);
  EXPECT_TRUE(flight_.warnings.empty()) << "nor do the two contradict each other";
  EXPECT_THAT(captures_.bands[0].method, HasSubstr("without 1 of another day"));
}

TEST_F(CalibrateByPanelsTest, EachDayIsHeldAgainstItsOwnPanel) {
  PutApart(1);
  captures_.panels.pop_back();  // that of nir
  TakePanelsBefore(1, captures_);
  captures_.panels.push_back(captures_.panels[0]);
  captures_.panels.back().photo.name = "second.tif";
  *captures_.panels.back().photo.captured_at += std::chrono::hours(24);
  source_.pictures["second.tif"] = Draw({.grey = 16'000});
  for (std::size_t i = 4; i < captures_.captures.size(); ++i) {
    for (BandPhoto& photo : captures_.captures[i].photos) *photo.photo.captured_at += std::chrono::hours(24);
  }
  captures_.captures[3].photos[0].photo.captured_at.reset();
  CalibrateByPanels(flight_, captures_, source_);
  const auto factor_of = [&](std::size_t capture) {
    return captures_.captures[capture].photos[0].facts.radiometry.per_level * 50'000.0;
  };
  EXPECT_NEAR(factor_of(0), kRed / 0.5, 1e-6);
  EXPECT_NEAR(factor_of(4), kRed / 0.3, 1e-6);
  EXPECT_NEAR(factor_of(3), (kRed / 0.5 + kRed / 0.3) / 2.0, 1e-6) << "without a clock";
  EXPECT_TRUE(flight_.warnings.empty()) << "the panels do not contradict each other";
  EXPECT_THAT(captures_.bands[0].method, HasSubstr("by 2 pictures of RP04-1924106-OB, each day by its own"));
}

TEST_F(CalibrateByPanelsTest, EachCameraIsHeldAgainstItsOwnPanel) {
  PutApart(1);
  for (std::size_t i = 0; i < captures_.captures.size(); ++i) {
    for (BandPhoto& photo : captures_.captures[i].photos) photo.photo.camera_key = i < 4 ? "A" : "B";
  }
  for (BandPhoto& panel : captures_.panels) panel.photo.camera_key = "A";
  captures_.panels.push_back(captures_.panels[0]);
  captures_.panels.back().photo.name = "second.tif";
  captures_.panels.back().photo.camera_key = "B";
  source_.pictures["second.tif"] = Draw({.grey = 16'000});
  CalibrateByPanels(flight_, captures_, source_);
  EXPECT_NEAR(captures_.captures[0].photos[0].facts.radiometry.per_level * 50'000.0, kRed / 0.5, 1e-6);
  EXPECT_NEAR(FactorOf("red"), kRed / 0.3, 1e-6);
  EXPECT_NEAR(FactorOf("nir"), kNir, 1e-6) << "its camera has none of its own";
  ASSERT_THAT(flight_.warnings, SizeIs(1));
  EXPECT_THAT(InWords(flight_.warnings[0]), HasSubstr("3 photos of bands"));
}

TEST_F(CalibrateByPanelsTest, PicturesThatContradictAreTold) {
  PutApart(1);
  captures_.panels.push_back(captures_.panels[0]);
  captures_.panels.back().photo.name = "second.tif";
  source_.pictures["second.tif"] = Draw({.grey = 16'000});
  CalibrateByPanels(flight_, captures_, source_);
  ASSERT_THAT(flight_.warnings, SizeIs(1));
  EXPECT_THAT(InWords(flight_.warnings[0]), HasSubstr("the band red"));
  EXPECT_NEAR(FactorOf("red"), (kRed / 0.5 + kRed / 0.3) / 2.0, 1e-6);
}

}  // namespace
}  // namespace skyquilt::bands
