#include "core/video/films.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <map>
#include <set>

#include "core/flight/photos/read_photo.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/video/moving_film.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::video {
namespace {

// As DJI cameras write: one subtitle a second.
std::string Subtitles(int seconds, double lat_deg = 47.0) {
  std::string text;
  for (int s = 0; s < seconds; ++s) {
    text += fmt::format(
        "{}\n00:00:{:02},000 --> 00:00:{:02},000\n[iso : 100] [shutter : 1/500.0] [latitude: {:.6f}] [longitude: 8.500000] "
        "[rel_alt: 50.000 abs_alt: 412.300]\n\n",
        s + 1, s, s + 1, lat_deg + 1e-5 * s);
  }
  return text;
}

constexpr flight::UtcTime kFilmedAt{std::chrono::seconds(1'695'038'303)};  // 2023-09-18 11:58:23

// As a camera writes it, into the header of the film (ISO/IEC 14496-12, 8.2.2: seconds since 1904).
void SetCreation(const std::filesystem::path& path, flight::UtcTime time) {
  std::string bytes = test::BytesOf(path);
  const std::size_t header = bytes.find("mvhd");
  ASSERT_NE(header, std::string::npos);
  const auto since_1904 = static_cast<std::uint32_t>(
      std::chrono::floor<std::chrono::seconds>(time).time_since_epoch().count() + 2'082'844'800);
  for (std::size_t i = 0; i < 4; ++i)
    bytes[header + 8 + i] = static_cast<char>(since_1904 >> (24 - 8 * i) & 0xFFU);
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

std::vector<flight::Photo> PhotosOf(const FlightFiles& given) {
  std::vector<flight::Photo> photos;
  for (const flight::InputFile& file : given.files) {
    if (!file.name.ends_with(".jpg")) continue;
    const std::string bytes = test::BytesOf(file.path);
    const auto photo = flight::ReadPhotoFromBytes(
        file.name, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    EXPECT_TRUE(photo) << file.name;
    if (photo) photos.push_back(*photo);
  }
  return photos;
}

class FilmsTest : public testing::Test {
 protected:
  flight::InputFile File(const std::string& name) const { return {name, folder_.path() / name}; }
  Result<FlightFiles> Replace(const std::vector<flight::InputFile>& files) {
    SilentProgress progress;
    std::filesystem::create_directories(folder_.path() / "frames");
    return WithFramesOfFilms(files, FilmsAmong(files), folder_.path() / "frames", {}, progress);
  }
  test::TemporaryFolder folder_;
};

TEST_F(FilmsTest, BecomePhotosWithATableOfTheirPlaces) {
  if (!WriteFilm(folder_.path() / "DJI_0001.MP4", 90, [](int k) { return 6 * k; }))
    GTEST_SKIP() << "no MPEG-4 encoder";
  folder_.Write("dji_0001.srt", Subtitles(4));
  folder_.Write("photo.jpg", "\xff\xd8\xff");
  const auto given = test::ValueOf(Replace({File("DJI_0001.MP4"), File("dji_0001.srt"), File("photo.jpg")}));
  EXPECT_TRUE(given.warnings.empty()) << flight::InWords(given.warnings.front());
  std::vector<std::string> names;
  for (const flight::InputFile& file : given.files) names.push_back(file.name);
  EXPECT_EQ(names.front(), "photo.jpg");
  EXPECT_EQ(names.back(), "DJI_0001_frames.csv");
  EXPECT_EQ(names[1], "DJI_0001_000000.jpg");
  EXPECT_EQ(std::count(names.begin(), names.end(), "dji_0001.srt"), 0);
  ASSERT_EQ(given.sources.size(), 2U);
  EXPECT_EQ(given.sources[1].name, "dji_0001.srt");
  const std::string text = test::BytesOf(given.files.back().path);
  EXPECT_NE(text.find("\"DJI_0001_000000.jpg\",47.0000"), std::string::npos) << text;
  EXPECT_NE(text.find(",50.000,"), std::string::npos) << text;
}

TEST_F(FilmsTest, OfOneNameKeepTheirFramesApart) {
  for (const char* card : {"one", "two"}) {
    std::filesystem::create_directory(folder_.path() / card);
    if (!WriteFilm(folder_.path() / card / "DJI_0001.MP4", 60, [](int k) { return 6 * k; }))
      GTEST_SKIP() << "no MPEG-4 encoder";
  }
  const auto given = Replace({{"one/DJI_0001.MP4", folder_.path() / "one/DJI_0001.MP4"},
                              {"two/DJI_0001.MP4", folder_.path() / "two/DJI_0001.MP4"}});
  ASSERT_TRUE(given) << given.error().message;
  std::set<std::string> names;
  for (const flight::InputFile& file : given->files) names.insert(file.name);
  EXPECT_EQ(names.size(), given->files.size());
  EXPECT_TRUE(names.contains("DJI_0001_000000.jpg"));
  EXPECT_TRUE(names.contains("DJI_0001_2_000000.jpg"));
  EXPECT_EQ(given->sources.size(), 2U);
}

// As of three cards, of which the last has none.
TEST_F(FilmsTest, OfOneNameHaveTheSubtitlesBesideThem) {
  std::vector<flight::InputFile> files;
  for (const char* card : {"one", "two", "three"}) {
    std::filesystem::create_directory(folder_.path() / card);
    files.push_back(File(fmt::format("{}/DJI_0001.MP4", card)));
    if (!WriteFilm(files.back().path, 60, [](int k) { return 6 * k; })) GTEST_SKIP() << "no MPEG-4 encoder";
  }
  files.push_back(File("one/DJI_0001.SRT"));
  files.push_back(File("two/dji_0001.srt"));
  folder_.Write("one/DJI_0001.SRT", Subtitles(2));
  folder_.Write("two/dji_0001.srt", Subtitles(2, 46.0));
  const auto given = test::ValueOf(Replace(files));
  std::map<std::string, std::string> tables;
  for (const flight::InputFile& file : given.files) {
    EXPECT_FALSE(file.name.ends_with("SRT") || file.name.ends_with("srt")) << file.name;
    if (file.name.ends_with(".csv")) tables[file.name] = test::BytesOf(file.path);
  }
  ASSERT_EQ(tables.size(), 2U);
  EXPECT_NE(tables["DJI_0001_frames.csv"].find(",47.0000"), std::string::npos);
  EXPECT_NE(tables["DJI_0001_2_frames.csv"].find(",46.0000"), std::string::npos);
}

TEST_F(FilmsTest, NameSubtitlesThatBelongToNoneOfThemWhereOneHasNone) {
  for (const char* film : {"DJI_0001.MP4", "DJI_0002.MP4"}) {
    if (!WriteFilm(folder_.path() / film, 60, [](int k) { return 6 * k; }))
      GTEST_SKIP() << "no MPEG-4 encoder";
  }
  folder_.Write("DJI_0001.SRT", Subtitles(2));
  folder_.Write("flight.SRT", Subtitles(2));
  const std::vector<flight::InputFile> files{File("DJI_0001.MP4"), File("DJI_0001.SRT"), File("flight.SRT")};
  EXPECT_TRUE(test::ValueOf(Replace(files)).warnings.empty());
  std::vector<flight::InputFile> more = files;
  more.push_back(File("DJI_0002.MP4"));
  const auto given = test::ValueOf(Replace(more));
  ASSERT_EQ(given.warnings.size(), 1U);
  EXPECT_EQ(given.warnings[0].code, flight::RemarkCode::kSubtitlesOfNoFilm);
  EXPECT_EQ(flight::InWords(given.warnings[0]),
            "flight.SRT says nothing of DJI_0002.MP4: subtitles are those of the film of their name. If they "
            "are its own, name them DJI_0002.SRT.");
}

// A film that was cut, or subtitles of another.
TEST_F(FilmsTest, SayThatTheirSubtitlesLastLonger) {
  if (!WriteFilm(folder_.path() / "DJI_0001.MP4", 60, [](int k) { return 6 * k; }))
    GTEST_SKIP() << "no MPEG-4 encoder";
  folder_.Write("DJI_0001.SRT", Subtitles(40));
  const auto given = test::ValueOf(Replace({File("DJI_0001.MP4"), File("DJI_0001.SRT")}));
  ASSERT_EQ(given.warnings.size(), 1U);
  EXPECT_EQ(given.warnings[0].code, flight::RemarkCode::kSubtitlesOfOtherLength);
}

TEST_F(FilmsTest, GiveTheirFramesTheTimeOfTheirCreation) {
  const std::filesystem::path film = folder_.path() / "film.MP4";
  if (!WriteFilm(film, 60, [](int k) { return 6 * k; })) GTEST_SKIP() << "no MPEG-4 encoder";
  ASSERT_NO_FATAL_FAILURE(SetCreation(film, kFilmedAt));
  const auto alone = test::ValueOf(Replace({File("film.MP4")}));
  EXPECT_TRUE(alone.warnings.empty());
  const std::vector<flight::Photo> photos = PhotosOf(alone);
  ASSERT_GE(photos.size(), 2U);
  EXPECT_EQ(photos.front().captured_at, kFilmedAt);
  EXPECT_TRUE(photos.front().captured_at_is_local);
  ASSERT_TRUE(photos.back().captured_at);
  EXPECT_GT(*photos.back().captured_at, kFilmedAt);
  EXPECT_LE(*photos.back().captured_at, kFilmedAt + std::chrono::seconds(2));
  // Beside a track it counts whether that was the beginning or the end.
  folder_.Write("way.gpx",
                "<?xml version=\"1.0\"?><gpx xmlns=\"http://www.topografix.com/GPX/1/1\"><trk><trkseg>"
                "<trkpt lat=\"47\" lon=\"8\"><time>2023-09-18T11:58:20Z</time></trkpt>"
                "<trkpt lat=\"47.001\" lon=\"8\"><time>2023-09-18T11:58:30Z</time></trkpt>"
                "</trkseg></trk></gpx>\n");
  const auto beside = test::ValueOf(Replace({File("film.MP4"), File("way.gpx")}));
  ASSERT_EQ(beside.warnings.size(), 1U);
  EXPECT_EQ(beside.warnings[0].code, flight::RemarkCode::kFilmTimedByCreation);
  EXPECT_EQ(beside.warnings[0].values.at("at"), flight::RemarkValue("2023-09-18 11:58:23"));
  EXPECT_EQ(beside.warnings[0].values.at("name"), flight::RemarkValue("20230918_115821.MP4"));
}

TEST_F(FilmsTest, BeganWhenTheirNameSays) {
  const std::filesystem::path film = folder_.path() / "DJI_20230918115823_0001_D.MP4";
  if (!WriteFilm(film, 60, [](int k) { return 6 * k; })) GTEST_SKIP() << "no MPEG-4 encoder";
  ASSERT_NO_FATAL_FAILURE(SetCreation(film, kFilmedAt - std::chrono::hours(2) + std::chrono::seconds(2)));
  const auto given = test::ValueOf(Replace({File("DJI_20230918115823_0001_D.MP4")}));
  const std::vector<flight::Photo> photos = PhotosOf(given);
  ASSERT_FALSE(photos.empty());
  EXPECT_EQ(photos.front().captured_at, kFilmedAt);
}

// One clock ties all frames to a track: a name's is local, a creation's UTC.
TEST_F(FilmsTest, BeganWhenTheyWereCreatedWhereNotAllNamesSayIt) {
  const std::vector<flight::InputFile> films{File("DJI_20230918135823_0001_D.MP4"), File("second.MP4")};
  flight::UtcTime created = kFilmedAt;
  for (const flight::InputFile& film : films) {
    if (!WriteFilm(film.path, 60, [](int k) { return 6 * k; })) GTEST_SKIP() << "no MPEG-4 encoder";
    ASSERT_NO_FATAL_FAILURE(SetCreation(film.path, created));
    created += std::chrono::minutes(1);
  }
  const auto given = test::ValueOf(Replace(films));
  const std::vector<flight::Photo> photos = PhotosOf(given);
  const auto second = std::find_if(photos.begin(), photos.end(), [](const flight::Photo& photo) {
    return photo.name.starts_with("second");
  });
  ASSERT_NE(second, photos.end());
  EXPECT_EQ(photos.front().captured_at, kFilmedAt);
  EXPECT_EQ(second->captured_at, kFilmedAt + std::chrono::minutes(1));
}

TEST_F(FilmsTest, HaveNoTimesWhereOneBeganWhileAnotherWasTaken) {
  const std::vector<flight::InputFile> films{File("a.MP4"), File("b.MP4")};
  for (const flight::InputFile& film : films) {
    if (!WriteFilm(film.path, 60, [](int k) { return 6 * k; })) GTEST_SKIP() << "no MPEG-4 encoder";
    ASSERT_NO_FATAL_FAILURE(SetCreation(film.path, kFilmedAt));
  }
  const auto given = test::ValueOf(Replace(films));
  const std::vector<flight::Photo> photos = PhotosOf(given);
  EXPECT_FALSE(photos.empty());
  EXPECT_TRUE(std::none_of(photos.begin(), photos.end(),
                           [](const flight::Photo& photo) { return photo.captured_at.has_value(); }));
}

TEST_F(FilmsTest, AreToldFromOtherFiles) {
  folder_.Write("photo.jpg", "\xff\xd8\xff");
  folder_.Write("log.srt", Subtitles(4));
  EXPECT_TRUE(FilmsAmong({File("photo.jpg"), File("log.srt"), File("missing.jpg")}).empty());
}

// As DJI writes beside each film; alone it is all there is.
TEST_F(FilmsTest, LeaveOutSmallCopiesBesideThem) {
  const std::filesystem::path film = folder_.path() / "DJI_0001.MP4";
  if (!WriteFilm(film, 60, [](int k) { return 6 * k; })) GTEST_SKIP() << "no MPEG-4 encoder";
  ASSERT_NO_FATAL_FAILURE(SetCreation(film, kFilmedAt));
  std::filesystem::copy_file(film, folder_.path() / "DJI_0001.LRF");
  const auto given = test::ValueOf(Replace({File("DJI_0001.LRF"), File("DJI_0001.MP4")}));
  ASSERT_EQ(given.sources.size(), 1U);
  EXPECT_EQ(given.sources[0].name, "DJI_0001.MP4");
  ASSERT_EQ(given.warnings.size(), 1U);
  EXPECT_EQ(given.warnings[0].code, flight::RemarkCode::kFilmPreviews);
  EXPECT_EQ(given.files.front().name, "DJI_0001_000000.jpg");
  EXPECT_TRUE(PhotosOf(given).front().captured_at);
  const auto alone = test::ValueOf(Replace({File("DJI_0001.LRF")}));
  ASSERT_EQ(alone.sources.size(), 1U);
  EXPECT_EQ(alone.sources[0].name, "DJI_0001.LRF");
}

TEST_F(FilmsTest, NamesAFilmThatCannotBeReadAndGoesOn) {
  folder_.Write("broken.mp4", std::string("\0\0\0\x18"
                                          "ftypmp42",
                                          12) +
                                  std::string(400, 'x'));
  folder_.Write("photo.jpg", "\xff\xd8\xff");
  const auto given = test::ValueOf(Replace({File("broken.mp4"), File("photo.jpg")}));
  ASSERT_EQ(given.warnings.size(), 1U);
  EXPECT_NE(flight::InWords(given.warnings[0]).find("broken.mp4"), std::string::npos);
  ASSERT_EQ(given.files.size(), 1U);
  EXPECT_EQ(given.files[0].name, "photo.jpg");
}

}  // namespace
}  // namespace skyquilt::video
