#include "core/video/video_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/video/moving_film.h"
#include "tests/support/bytes_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::video {
namespace {

class VideoFileTest : public testing::Test {
 protected:
  void SetUp() override {
    path_ = folder_.path() / "film.mp4";
    if (!WriteFilm(path_, 60, [](int k) { return 4 * k; }))
      GTEST_SKIP() << "no MPEG-4 encoder on this machine";
  }
  std::string Bytes() const { return test::BytesOf(path_); }
  test::TemporaryFolder folder_;
  std::filesystem::path path_;
};

TEST_F(VideoFileTest, GivesEveryFrameWithItsTime) {
  auto film = test::ValueOf(VideoFile::Open(path_, 2));
  EXPECT_EQ(film.facts().width_px, kFilmWidthPx);
  EXPECT_EQ(film.facts().height_px, kFilmHeightPx);
  EXPECT_NEAR(film.facts().duration_s, 2.0, 0.1);
  for (int k = 0; k < 60; ++k) {
    const auto next = film.Next();
    ASSERT_TRUE(next && *next) << k;
    EXPECT_EQ(film.number(), k);
    EXPECT_NEAR(film.time_s(), k / 30.0, 1e-3);
  }
  EXPECT_FALSE(*film.Next());
}

TEST_F(VideoFileTest, KeepsAFrameWhileOthersPass) {
  auto film = VideoFile::Open(path_, 1);
  ASSERT_TRUE(*film->Next());
  film->Keep();
  const GrayFrame first = *film->Gray(kFilmWidthPx);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(*film->Next());
  const GrayFrame later = *film->Gray(320);
  EXPECT_EQ(later.width_px, 320);
  EXPECT_EQ(later.height_px, 240);
  const auto kept = test::ValueOf(film->Kept());
  ASSERT_EQ(kept.width_px, kFilmWidthPx);
  double off = 0.0;
  for (int y = 0; y < kFilmHeightPx; y += 7) {
    for (int x = 0; x < kFilmWidthPx; x += 7) {
      const std::uint8_t* rgb = kept.Row(y) + 3 * x;
      off += std::abs(0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2] -
                      first.gray[static_cast<std::size_t>(y * kFilmWidthPx + x)]);
    }
  }
  EXPECT_LT(off / ((kFilmHeightPx / 7) * (kFilmWidthPx / 7)), 20.0);
}

// As cameras write into the head of a film (ISO/IEC 14496-12, 12.1.5).
std::string DeclaredAsBt709(std::string film) {
  const std::string colours(
      "\0\0\0\x13"
      "colrnclx\0\1\0\1\0\1\0",
      19);
  std::size_t at = film.rfind("moov"), end = 0;
  EXPECT_LT(film.find("mdat"), at) << "what lies behind the head would move";
  for (const char* box : {"moov", "trak", "mdia", "minf", "stbl", "stsd", "mp4v"}) {
    at = film.find(box, at);
    if (at == std::string::npos) return "";
    std::uint32_t size = 0;
    for (std::size_t i = 0; i < 4; ++i) size = size << 8 | static_cast<std::uint8_t>(film[at - 4 + i]);
    end = at - 4 + size;
    size += static_cast<std::uint32_t>(colours.size());
    for (std::size_t i = 0; i < 4; ++i) film[at - 4 + i] = static_cast<char>(size >> (24 - 8 * i) & 0xFFU);
  }
  return film.insert(end, colours);
}

image::DecodedImage FirstOf(const std::filesystem::path& path) {
  auto film = test::ValueOf(VideoFile::Open(path, 1));
  EXPECT_TRUE(test::ValueOf(film.Next()));
  film.Keep();
  return test::ValueOf(film.Kept());
}

// The same levels in other colours: as bright by the weights of theirs.
TEST_F(VideoFileTest, HasTheColoursThatItDeclares) {
  const image::DecodedImage usual = FirstOf(path_),
                            declared = FirstOf(folder_.Write("709.mp4", DeclaredAsBt709(Bytes())));
  ASSERT_EQ(declared.rgb.size(), usual.rgb.size());
  double off = 0.0, greens_off = 0.0;
  for (std::size_t i = 0; i + 2 < usual.rgb.size(); i += 3) {
    const std::uint8_t *a = usual.rgb.data() + i, *b = declared.rgb.data() + i;
    off += std::abs(0.2126 * b[0] + 0.7152 * b[1] + 0.0722 * b[2] -
                    (0.299 * a[0] + 0.587 * a[1] + 0.114 * a[2]));
    greens_off += std::abs(b[1] - a[1]);
  }
  const double pixels = static_cast<double>(usual.rgb.size()) / 3.0;
  EXPECT_LT(off / pixels, 2.5);
  EXPECT_GT(greens_off / pixels, 1.0);
}

TEST_F(VideoFileTest, RefusesWhatIsNoFilm) {
  for (const auto& [name, bytes] : {std::pair{"empty.mp4", std::string()},
                                    {"words.mp4", std::string(5000, 'x')},
                                    {"head.mp4", Bytes().substr(0, 40)}}) {
    const auto film = VideoFile::Open(folder_.Write(name, bytes), 1);
    ASSERT_FALSE(film) << name;
    EXPECT_EQ(film.error().code, ErrorCode::kUnsupportedFormat);
    EXPECT_NE(film.error().message.find(name), std::string::npos) << film.error().message;
  }
  EXPECT_FALSE(VideoFile::Open(folder_.path() / "none.mp4", 1));
}

TEST_F(VideoFileTest, EndsWhereAFilmIsDamaged) {
  std::string bytes = Bytes();
  const std::size_t middle = bytes.size() / 3;
  for (std::size_t i = middle; i < middle + 2000 && i < bytes.size(); ++i)
    bytes[i] = static_cast<char>(i * 37);
  auto film = VideoFile::Open(folder_.Write("damaged.mp4", bytes), 2);
  if (!film) return;  // its index was hit
  int frames = 0;
  for (;; ++frames) {
    const auto next = film->Next();
    if (!next || !*next) break;
    ASSERT_LT(frames, 1000);
  }
}

TEST_F(VideoFileTest, HasNoSubtitlesUnlessTheCameraWroteThem) {
  EXPECT_EQ(test::ValueOf(VideoFile::Subtitles(path_)), "");
}

}  // namespace
}  // namespace skyquilt::video
