#include "core/video/take_frames.h"

#include <gtest/gtest.h>

#include <charconv>

#include "core/flight/remarks/remark_words.h"
#include "tests/core/video/moving_film.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::video {
namespace {

// The frame's number in "film_000021.jpg".
int NumberOf(const flight::InputFile& photo) {
  int number = -1;
  const std::string text = photo.name.substr(photo.name.find('_') + 1, 6);
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

struct Taken {
  test::TemporaryFolder folder;
  Result<TakenFrames> frames = Error{ErrorCode::kNotFound, "", ""};
  bool is_filmed = false;

  Taken(int count, const std::function<int(int)>& left_px, TakeFramesOptions options = {}) {
    const std::filesystem::path film = folder.path() / "film.mp4";
    is_filmed = WriteFilm(film, count, left_px);
    SilentProgress progress;
    if (is_filmed) frames = TakeFrames({"film.mp4", film}, std::nullopt, folder.path(), options, progress);
  }
};

TEST(TakeFrames, TakesThemAsFarApartAsTheyMayOverlap) {
  const Taken taken(150, [](int k) { return 6 * k; });
  if (!taken.is_filmed) GTEST_SKIP() << "no MPEG-4 encoder on this machine";
  ASSERT_TRUE(taken.frames) << taken.frames.error().message;
  const auto& photos = taken.frames->photos;
  ASSERT_GE(photos.size(), 7U);
  EXPECT_LE(photos.size(), 14U);
  EXPECT_EQ(NumberOf(photos.front()), 0);
  for (std::size_t i = 1; i < photos.size(); ++i) {
    const int moved_px = 6 * (NumberOf(photos[i]) - NumberOf(photos[i - 1]));
    if (i + 1 < photos.size()) {
      EXPECT_GE(moved_px, 0.12 * kFilmWidthPx);
    }
    EXPECT_LE(moved_px, 0.26 * kFilmWidthPx);
    EXPECT_NEAR(taken.frames->times_s[i], NumberOf(photos[i]) / 30.0, 1e-3);
  }
  for (const auto& photo : photos) EXPECT_GT(std::filesystem::file_size(photo.path), 1000U);
  EXPECT_FALSE(taken.frames->table);
}

TEST(TakeFrames, TakesOneOfACameraThatStands) {
  const Taken taken(90, [](int) { return 0; });
  if (!taken.is_filmed) GTEST_SKIP() << "no MPEG-4 encoder on this machine";
  ASSERT_TRUE(taken.frames);
  EXPECT_EQ(taken.frames->photos.size(), 1U);
}

TEST(TakeFrames, TakesBothSidesOfACut) {
  const Taken taken(60, [](int k) { return k < 30 ? 0 : 5000; });
  if (!taken.is_filmed) GTEST_SKIP() << "no MPEG-4 encoder on this machine";
  ASSERT_TRUE(taken.frames);
  ASSERT_EQ(taken.frames->photos.size(), 2U);
  EXPECT_LT(NumberOf(taken.frames->photos[0]), 30);
  EXPECT_GE(NumberOf(taken.frames->photos[1]), 30);
}

TEST(TakeFrames, TakesFewWhereNothingCanBeFollowedAndGoesOnBehind) {
  constexpr int kLost = 450, kAll = 600;  // of 15 s every fourth frame is looked at: 113, none like the next
  const auto left_px = [](int k) { return k < kLost ? k / 4 % 5 * 700 : 6 * (k - kLost); };
  TakeFramesOptions options;
  options.max_frames = 120;  // 60 of these may be over water: three a second
  const Taken taken(kAll, left_px, options);
  if (!taken.is_filmed) GTEST_SKIP() << "no MPEG-4 encoder on this machine";
  ASSERT_TRUE(taken.frames) << taken.frames.error().message;
  std::vector<int> lost, followed;
  for (const auto& photo : taken.frames->photos)
    (NumberOf(photo) < kLost ? lost : followed).push_back(NumberOf(photo));
  EXPECT_GE(lost.size(), 15U);
  EXPECT_LE(lost.size(), 80U);
  ASSERT_GE(followed.size(), 4U);
  EXPECT_LE(followed.front(), kLost + 24) << "most of a second behind";
  for (std::size_t i = 1; i < followed.size(); ++i)
    EXPECT_LE(6 * (followed[i] - followed[i - 1]), 0.26 * kFilmWidthPx) << followed[i];
}

TEST(TakeFrames, SaysWhereItStoppedWhenThereAreTooMany) {
  TakeFramesOptions options;
  options.max_frames = 3;
  const Taken taken(
      150, [](int k) { return 6 * k; }, options);
  if (!taken.is_filmed) GTEST_SKIP() << "no MPEG-4 encoder on this machine";
  ASSERT_TRUE(taken.frames);
  EXPECT_EQ(taken.frames->photos.size(), 3U);
  ASSERT_EQ(taken.frames->warnings.size(), 1U);
  EXPECT_NE(flight::InWords(taken.frames->warnings[0]).find("film.mp4"), std::string::npos);
}

TEST(TakeFrames, SaysThatAFilmBreaksOff) {
  const test::TemporaryFolder folder;
  const std::filesystem::path whole = folder / "whole.mkv";  // Matroska says in its head how long it lasts
  if (!WriteFilm(whole, 240, [](int k) { return 6 * k; }))
    GTEST_SKIP() << "no MPEG-4 encoder on this machine";
  const std::string bytes = test::BytesOf(whole);
  const std::filesystem::path cut = folder.Write("cut.mkv", bytes.substr(0, bytes.size() / 3));
  const auto warnings_of = [&](const std::filesystem::path& film) {
    SilentProgress progress;
    const Result<TakenFrames> taken =
        TakeFrames({film.filename().string(), film}, std::nullopt, folder.path(), {}, progress);
    EXPECT_TRUE(taken.ok()) << film;
    return taken.ok() ? taken->warnings : std::vector<flight::Remark>();
  };
  EXPECT_TRUE(warnings_of(whole).empty());
  const std::vector<flight::Remark> of_cut = warnings_of(cut);
  ASSERT_EQ(of_cut.size(), 1U);
  EXPECT_EQ(of_cut[0].code, flight::RemarkCode::kFilmEndsEarly);
}

TEST(TakeFrames, IsTheSameWithAnyNumberOfThreads) {
  TakeFramesOptions four;
  four.threads = 4;
  const Taken one(60, [](int k) { return 9 * k; }), many(
                                                        60, [](int k) { return 9 * k; }, four);
  if (!one.is_filmed) GTEST_SKIP() << "no MPEG-4 encoder on this machine";
  ASSERT_TRUE(one.frames && many.frames);
  ASSERT_EQ(one.frames->photos.size(), many.frames->photos.size());
  for (std::size_t i = 0; i < one.frames->photos.size(); ++i) {
    EXPECT_EQ(one.frames->photos[i].name, many.frames->photos[i].name);
    EXPECT_EQ(std::filesystem::file_size(one.frames->photos[i].path),
              std::filesystem::file_size(many.frames->photos[i].path));
  }
}

flight::GnssSample Fix(double t_s, double lat_deg) {
  flight::GnssSample fix;
  fix.t_s = t_s;
  fix.position = {lat_deg, 8.0};
  fix.height_amsl_m = 100.0 + t_s;
  return fix;
}

TEST(FrameTable, IsBetweenTheSamplesByStraightLines) {
  flight::FlightLog log;
  log.gnss = {Fix(0.0, 50.0), Fix(2.0, 50.0002)};
  log.baro = {{0.0, 30.0}, {2.0, 31.0}};
  const std::string table = FrameTable({"a.jpg", "b \"1\".jpg"}, {0.5, 2.5}, log);
  EXPECT_NE(table.find("\"a.jpg\",50.000050000,8.000000000,100.500,,,30.250,,,\n"), std::string::npos)
      << table;
  EXPECT_NE(table.find("\"b \"\"1\"\".jpg\",50.000200000,8.000000000,102.000,,,31.000,,,\n"),
            std::string::npos)
      << table;
}

TEST(FrameTable, GoesTheShortWayRoundTheEarth) {
  flight::FlightLog log;
  log.gnss = {Fix(0.0, -17.0), Fix(2.0, -17.0)};
  log.gnss[0].position.lon_deg = 179.9998;
  log.gnss[1].position.lon_deg = -179.9999;
  const std::string table = FrameTable({"a.jpg", "b.jpg"}, {0.5, 1.5}, log);
  EXPECT_NE(table.find("\"a.jpg\",-17.000000000,179.999875000,"), std::string::npos) << table;
  EXPECT_NE(table.find("\"b.jpg\",-17.000000000,-179.999975000,"), std::string::npos) << table;
}

TEST(FrameTable, SaysNothingOfTimesThatTheLogDoesNotCover) {
  flight::FlightLog log;
  log.gnss = {Fix(0.0, 50.0), Fix(100.0, 50.1)};
  EXPECT_EQ(FrameTable({"a.jpg"}, {50.0}, log), "") << "too long a gap";
  EXPECT_EQ(FrameTable({"a.jpg"}, {200.0}, log), "");
  EXPECT_EQ(FrameTable({"a.jpg"}, {0.0}, {}), "");
  EXPECT_EQ(FrameTable({}, {}, log), "");
}

}  // namespace
}  // namespace skyquilt::video
