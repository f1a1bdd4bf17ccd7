#include "core/flight/remarks/remark_words.h"

#include <gmock/gmock.h>

#include <set>

#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

TEST(RemarkSentences, HaveNamesThatAreFoundAgain) {
  std::set<std::string_view> names;
  for (const RemarkSentence& one : RemarkSentences()) {
    EXPECT_TRUE(names.insert(one.name).second) << one.name;
    EXPECT_EQ(RemarkCodeOf(one.name), one.code);
    EXPECT_EQ(NameOf(one.code), one.name);
    EXPECT_EQ(one.one.empty(), one.counted.empty()) << one.name;
  }
  EXPECT_FALSE(RemarkCodeOf("no such remark"));
  EXPECT_FALSE(RemarkCodeOf(""));
}

TEST(InWords, CountsAndMeasures) {
  const auto rows = [](std::size_t count) {
    return InWords(
        Remark{RemarkCode::kListNamesNoPhoto, {{"file", "geo.txt"}, {"rows", count}, {"first", "a.jpg"}}});
  };
  EXPECT_THAT(rows(1),
              ::testing::StartsWith("geo.txt is not used: its rows name 1 photo (the first is a.jpg)"));
  EXPECT_THAT(rows(2), ::testing::HasSubstr("name 2 photos"));
  const auto apart = [](double apart_m) {
    return InWords(
        Remark{RemarkCode::kListReadOtherwise,
               {{"file", "geo.txt"},
                {"reading", std::vector<Remark>{{RemarkCode::kReadingSystem, {{"system", "EPSG:32632"}}},
                                                RemarkCode::kReadingNorthFirst}},
                {"apart_m", apart_m},
                {"own", Remark(RemarkCode::kOwnPhotos)}}});
  };
  EXPECT_EQ(
      apart(12.34),
      "geo.txt: read as EPSG:32632, north before east: as written it would lie 12.3 m from the photos' own "
      "positions.");
  EXPECT_THAT(apart(1234.0), ::testing::HasSubstr("lie 1,234 m from"));
  EXPECT_THAT(apart(5.2e6), ::testing::HasSubstr("lie 5,200 km from"));
}

TEST(InWords, SaysBracesOfNamesAsTheyAre) {
  EXPECT_EQ(InWords(Remark("50 % {of} {0} it")), "50 % {of} {0} it");
  EXPECT_THAT(InWords(Remark{RemarkCode::kFilm, {{"file", "{x}.mp4"}}}),
              ::testing::StartsWith("{x}.mp4 is a film."));
}

TEST(InWords, SaysWhyAPointIsNotUsed) {
  const auto noted = [](std::size_t marks, const char* names) {
    const Remark reason{RemarkCode::kPointMarksElsewhere, {{"marks", marks}, {"names", names}}};
    return InWords(Remark{RemarkCode::kControlNoted, {{"point", "P1"}, {"reason", reason}}});
  };
  EXPECT_EQ(
      noted(1, "a.jpg"),
      "Ground control point P1 is marked in a.jpg elsewhere than the other photos show it; that mark is "
      "left out.");
  EXPECT_EQ(
      noted(2, "a.jpg, b.jpg"),
      "Ground control point P1 is marked in 2 photos (a.jpg, b.jpg) elsewhere than the other photos show "
      "it; those marks are left out.");
}

TEST(InOneLine, SetsSemicolonsBetween) {
  const Remark as_neighbours{RemarkCode::kByPoseAsNeighbours, {{"points", 3}}};
  EXPECT_EQ(InOneLine({}), "");
  EXPECT_EQ(InOneLine({RemarkCode::kDoubtBlurred}), "is blurred");
  EXPECT_EQ(InOneLine({as_neighbours, RemarkCode::kDoubtBlurred}),
            "placed by its recorded pose, corrected as its neighbours were: too few points in common with "
            "other photos (3); is blurred");
}

TEST(InARow, SaysOneAfterTheOther) {
  const Remark few{RemarkCode::kFailFewPoints, {{"points", 4}, {"used", 2}, {"needed", 3}}};
  const Remark often{RemarkCode::kSoWithMore, {{"photos", 5}}};
  EXPECT_EQ(InARow({few}), few);
  EXPECT_EQ(InWords(InARow({})), "");
  EXPECT_EQ(InWords(InARow({"One.", often, "Two.", often})),
            "One. So it is with 5 more. Two. So it is with 5 more.");
}

TEST(Because, HasTheSentenceAndTheCode) {
  const Error error =
      Because(ErrorCode::kUnprocessable,
              {RemarkCode::kFailTime,
               {{"limit_s", 4.0}, {"where", Remark{RemarkCode::kInStage, {{"stage", "check"}}}}}},
              "7 s");
  EXPECT_THAT(error.message,
              ::testing::HasSubstr("took more than 4 seconds and was still in the stage \"check\". One"));
  EXPECT_EQ(error.detail, "7 s");
  EXPECT_EQ(WhyOf(error).code, RemarkCode::kFailTime);
  EXPECT_THAT(InWords(Remark{RemarkCode::kFailProcessorTime, {{"limit_s", 600.0}, {"where", "there"}}}),
              ::testing::HasSubstr("more than 10 minutes of processor time"));
}

TEST(WhyOf, SaysWhatTheKindOrElseTheMessageSays) {
  EXPECT_EQ(WhyOf({ErrorCode::kOutOfSpace, "/d: no space", ""}), Remark(RemarkCode::kFailDiskFull));
  EXPECT_EQ(WhyOf({ErrorCode::kCancelled, "Stopped.", ""}), Remark(RemarkCode::kFailCancelled));
  EXPECT_EQ(WhyOf({ErrorCode::kIo, "A cable is loose.", ""}), Remark("A cable is loose."));
  EXPECT_FALSE(HasReason({ErrorCode::kIo, "A cable is loose.", ""}));
}

// As a damaged file of an earlier run may have them.
TEST(InWords, FallsBackToTheCodeWhereValuesAreMissingOrOfAnotherKind) {
  EXPECT_EQ(InWords(Remark(RemarkCode::kGroups)), "groups");
  EXPECT_EQ(InWords(Remark{RemarkCode::kPositionCorrected, {{"off_m", "far"}}}), "position_corrected");
}

}  // namespace
}  // namespace skyquilt::flight
