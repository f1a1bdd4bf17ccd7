// How true a map is: its words, its digits, and its JSON from processes that are not trusted.
#include "core/pipeline/report/map_quality.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace skyquilt::pipeline {

extern const std::string_view kAccuracyTexts;  // tests/web/support/accuracy_texts.json

namespace {

MapQuality Placed() {
  return {MapStatus::kLimited,
          {2.3, AbsoluteSupport::kGnss, 42},
          {0.012, 0.7, RelativeSupport::kSeams, 31},
          {{LimitKind::kLeftOut, 1, 43}}};
}

TEST(MapQuality, HasTheDigitsThatThePageGivesIt) {
  const auto texts = nlohmann::json::parse(kAccuracyTexts);
  ASSERT_GE(texts.size(), 10u);
  for (const auto& one : texts)
    EXPECT_EQ(AccuracyText(one.at(0).get<double>()), one.at(1).get<std::string>()) << one;
}

TEST(MapQuality, IsRoundedToTwoDigits) {
  EXPECT_EQ(OfTwoDigits(2.2725), 2.3);
  EXPECT_EQ(OfTwoDigits(0.030303), 0.03);
  EXPECT_EQ(OfTwoDigits(0.996), 1.0);
  EXPECT_EQ(OfTwoDigits(1234.0), 1200.0);
  for (const double none : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), HUGE_VAL})
    EXPECT_EQ(OfTwoDigits(none), 0.0);
}

TEST(MapQuality, IsSaidInWords) {
  EXPECT_EQ(AbsoluteInWords(Placed()), "+-2.3 m (1 sigma), by 42 positions of GNSS");
  EXPECT_EQ(RelativeInWords(Placed()), "1.2 cm (0.7 px), at 31 places along seams");
  EXPECT_EQ(LimitInWords(Placed().limits[0]), "1 of 43 photos was left out: the map may have gaps there.");
  MapQuality few = Placed();
  few.absolute = {std::nullopt, AbsoluteSupport::kGnss, 1};
  few.limits = {{LimitKind::kFewPositions, 1, 42}};
  EXPECT_EQ(AbsoluteInWords(few), "unknown: only 1 of 42 photos with a position");
  MapQuality guessed = few;
  guessed.absolute.count = 12;
  guessed.limits = {{LimitKind::kScaleGuessed}};
  EXPECT_EQ(AbsoluteInWords(guessed), "unknown: the scale is a guess");
  guessed.limits = {{LimitKind::kNorthGuessed}};
  EXPECT_EQ(AbsoluteInWords(guessed), "unknown: north is a guess");
  EXPECT_NE(LimitInWords({LimitKind::kFewPositions, 1, 42}).find("Only 1 of 42 photos has a position"),
            std::string::npos);
}

TEST(MapQuality, OfAFlightReckonedFromAGivenPlaceSaysSo) {
  MapQuality reckoned = Placed();
  reckoned.absolute = {12.0, AbsoluteSupport::kHand, 42};
  EXPECT_EQ(AbsoluteInWords(reckoned), "+-12 m (1 sigma), by reckoning from a given place");
  reckoned.absolute.sigma_m.reset();
  EXPECT_EQ(AbsoluteInWords(reckoned), "unknown: placed by hand");
}

TEST(MapQuality, SaysNoNumberThatNothingSupports) {
  EXPECT_EQ(AbsoluteInWords({}), "unknown: no positions");
  EXPECT_EQ(RelativeInWords({}), "unknown: no photos are tied to each other");
  MapQuality unplaced = Placed();
  unplaced.absolute = {};
  unplaced.relative.error_m.reset();
  EXPECT_EQ(RelativeInWords(unplaced), "0.7 px, at 31 places along seams");
  EXPECT_NE(QualityJson(unplaced).find(R"("sigma_m":null,"by":"none")"), std::string::npos);
}

TEST(MapQuality, FarOffBlamesNoPositionsThatDidNotGiveTheNumber) {
  EXPECT_EQ(LimitInWords({LimitKind::kFarOff, 0, 0}).find("position"), std::string::npos);
}

TEST(MapQuality, SaysHowManyCheckPointsAreMissed) {
  EXPECT_NE(LimitInWords({LimitKind::kChecksMissed, 1, 3}).find("misses 1 of 3 check points"),
            std::string::npos);
}

TEST(MapQuality, IsSaidInOneLine) {
  const MapQuality quality = Placed();
  EXPECT_EQ(QualityInWords(quality), std::string(StatusInWords(quality.status)) +
                                         ". Absolute accuracy: " + AbsoluteInWords(quality) +
                                         ". Relative: " + RelativeInWords(quality) + ".");
}

TEST(MapQuality, OfAnImportedMapSaysThatItIsNotKnown) {
  MapQuality imported;
  imported.status = MapStatus::kUnknown;
  EXPECT_EQ(StatusInWords(imported.status), "Accuracy not known");
  EXPECT_EQ(AbsoluteInWords(imported), "unknown: an imported map");
  EXPECT_EQ(RelativeInWords(imported), "unknown: an imported map");
  EXPECT_EQ(ParseQuality(QualityJson(imported)).value(), imported);
}

TEST(MapQuality, IsReadAgainAndEveryWordHasAName) {
  MapQuality all = Placed();
  all.limits.clear();
  for (const auto& [kind, name] : kLimitKinds) {
    all.limits.push_back({kind, 1, 2});
    EXPECT_FALSE(LimitInWords(all.limits.back()).empty());
  }
  for (const auto& [status, word] : kMapStatuses) {
    for (const auto& [by, of] : kAbsoluteSupports) {
      all.status = status;
      all.absolute.by = by;
      const auto read = ParseQuality(QualityJson(all));
      ASSERT_TRUE(read) << QualityJson(all);
      EXPECT_EQ(*read, all);
    }
  }
}

TEST(MapQuality, ThatNoMapHasIsRefused) {
  using Pointer = nlohmann::json::json_pointer;
  const auto good = nlohmann::json::parse(QualityJson(Placed()));
  const std::vector<std::pair<const char*, nlohmann::json>> wrong = {
      {"/status", "good"},
      {"/status", nullptr},
      {"/absolute/sigma_m", -1.0},
      {"/absolute/sigma_m", "2"},
      {"/absolute/sigma_m", 1e300},
      {"/absolute/by", "wish"},
      {"/absolute/count", -1},
      {"/absolute/count", 0.5},
      {"/relative", 7},
      {"/relative/error_px", true},
      {"/limits/0/kind", "<script>"},
      {"/limits", "none"},
      {"/limits",
       nlohmann::json(std::vector<nlohmann::json>(std::size(kLimitKinds) + 1, good["limits"][0]))}};
  for (const auto& [where, value] : wrong) {
    auto json = good;
    json[Pointer(where)] = value;
    EXPECT_FALSE(ParseQuality(json.dump())) << where << " " << value;
  }
  for (const char* text : {"", "null", "[]", "{}", "{\"status\":", "7"})
    EXPECT_FALSE(ParseQuality(text)) << text;
}

}  // namespace
}  // namespace skyquilt::pipeline
