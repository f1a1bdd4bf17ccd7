#include "core/image/png_encoder.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>

#include "core/image/huffman_code.h"
#include "core/image/png_tile.h"

namespace skyquilt::image {
namespace {

enum class Paint { kNothing, kNoise, kSmooth, kPatches };

RgbaImage Painted(int size_px, Paint paint, std::uint32_t seed) {
  RgbaImage image = RgbaImage::Transparent(size_px, size_px);
  std::mt19937 random(seed);
  for (int y = 0; y < size_px; ++y) {
    for (int x = 0; x < size_px; ++x) {
      std::uint8_t* pixel = image.Pixel(x, y);
      if (paint == Paint::kNothing) continue;
      if (paint == Paint::kPatches && (x / 9 + y / 7 + static_cast<int>(seed)) % 3 == 0) continue;
      for (int c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>(paint == Paint::kSmooth ? 3 * x + 2 * y + c : random());
      pixel[3] = 255;
    }
  }
  return image;
}

cv::Mat Decoded(const std::vector<std::uint8_t>& png) { return cv::imdecode(png, cv::IMREAD_UNCHANGED); }

void ExpectSame(const RgbaImage& image, int left, int top, const cv::Mat& decoded) {
  ASSERT_EQ(decoded.type(), CV_8UC4);
  for (int y = 0; y < decoded.rows; ++y) {
    for (int x = 0; x < decoded.cols; ++x) {
      const auto bgra = decoded.at<cv::Vec4b>(y, x);
      const std::uint8_t* rgba = image.Pixel(left + x, top + y);
      ASSERT_TRUE(bgra[0] == rgba[2] && bgra[1] == rgba[1] && bgra[2] == rgba[0] && bgra[3] == rgba[3])
          << "at " << x << ", " << y;
    }
  }
}

TEST(EncodePng, PixelsComeBackAsTheyWere) {
  std::mt19937 random(7);
  for (const Paint paint : {Paint::kNothing, Paint::kNoise, Paint::kSmooth, Paint::kPatches}) {
    for (const int size_px : {1, 2, 3, 64, 65, 66, 129, 259, 512}) {
      const RgbaImage image = Painted(size_px, paint, random());
      ExpectSame(image, 0, 0, Decoded(EncodePng(image, 0, 0, size_px)));
    }
  }
}

TEST(EncodePng, TakesASquareOutOfALargerImage) {
  const RgbaImage image = Painted(512, Paint::kPatches, 3);
  const cv::Mat decoded = Decoded(EncodePng(image, 256, 128, 256));
  ASSERT_EQ(decoded.cols, 256);
  ExpectSame(image, 256, 128, decoded);
}

TEST(EncodePng, StoresStraightAlpha) {
  RgbaImage image = RgbaImage::Transparent(2, 2);
  const std::array<std::uint8_t, 4> half{50, 100, 10, 128};
  std::copy(half.begin(), half.end(), image.Pixel(1, 0));
  const auto pixel = Decoded(EncodePng(image, 0, 0, 2)).at<cv::Vec4b>(0, 1);
  EXPECT_EQ(pixel, cv::Vec4b(20, 199, 100, 128));
}

TEST(EncodePng, IsNoLargerThanAGeneralCompressorAtItsFastest) {
  // Noise over a slope, as photographs are.
  RgbaImage image = RgbaImage::Transparent(256, 256);
  std::mt19937 random(1);
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256 - y / 2; ++x) {
      for (int c = 0; c < 3; ++c)
        image.Pixel(x, y)[c] = static_cast<std::uint8_t>(60 + x / 4 + y / 3 + random() % 12);
      image.Pixel(x, y)[3] = 255;
    }
  }
  const std::vector<std::uint8_t> png = EncodePng(image, 0, 0, 256);
  std::vector<std::uint8_t> general;
  cv::imencode(".png", Decoded(png), general);
  EXPECT_LT(png.size(), general.size());
}

// Fibonacci's counts make the longest words; deflate allows 15 bits.
TEST(HuffmanCode, KeepsToFifteenBits) {
  std::vector<std::uint32_t> counts{1, 1};
  while (counts.size() < 30) counts.push_back(counts[counts.size() - 1] + counts[counts.size() - 2]);
  const HuffmanCode code = HuffmanCode::Of(counts);
  double room = 0.0;
  for (const HuffmanCode::Word& word : code.words) {
    ASSERT_GT(word.length, 0);
    ASSERT_LE(word.length, 15);
    room += std::pow(0.5, word.length);
  }
  EXPECT_DOUBLE_EQ(room, 1.0);
}

// Red, green, blue, alpha of a picture with smooth and rough parts.
cv::Mat Painted(int side_px, bool is_rough) {
  cv::Mat bgra(side_px, side_px, CV_8UC4);
  std::mt19937 random(3);
  for (int y = 0; y < side_px; ++y) {
    for (int x = 0; x < side_px; ++x) {
      for (int c = 0; c < 4; ++c)
        bgra.at<cv::Vec4b>(y, x)[c] = static_cast<std::uint8_t>(is_rough ? random() : 3 * x + 5 * y + 40 * c);
    }
  }
  return bgra;
}

std::string Png(const cv::Mat& picture, int strategy, int level) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", picture, bytes,
               {cv::IMWRITE_PNG_STRATEGY, strategy, cv::IMWRITE_PNG_COMPRESSION, level});
  return {bytes.begin(), bytes.end()};
}

// With FILTERED libpng chooses a filter row by row.
TEST(DecodePngTile, ReadsWhatOtherEncodersWrite) {
  for (const int side_px : {1, 5, 256}) {
    for (const bool is_rough : {false, true}) {
      for (const int strategy : {cv::IMWRITE_PNG_STRATEGY_DEFAULT, cv::IMWRITE_PNG_STRATEGY_FILTERED}) {
        for (const int level : {0, 1, 9}) {
          const cv::Mat picture = Painted(side_px, is_rough);
          const auto rgba = DecodePngTile(Png(picture, strategy, level), side_px);
          ASSERT_TRUE(rgba);
          for (int i = 0; i < side_px * side_px; ++i) {
            const auto& bgra = picture.at<cv::Vec4b>(i / side_px, i % side_px);
            const std::uint8_t* pixel = rgba->rgba.data() + 4 * i;
            ASSERT_TRUE(pixel[0] == bgra[2] && pixel[1] == bgra[1] && pixel[2] == bgra[0] &&
                        pixel[3] == bgra[3]);
          }
        }
      }
    }
  }
}

TEST(DecodePngTile, RefusesDamagedAndOtherPictures) {
  const std::string good = Png(Painted(64, true), cv::IMWRITE_PNG_STRATEGY_DEFAULT, 1);
  EXPECT_FALSE(DecodePngTile(good, 128));
  EXPECT_FALSE(DecodePngTile("", 64));
  cv::Mat grey(64, 64, CV_8UC1, cv::Scalar(7));
  EXPECT_FALSE(DecodePngTile(Png(grey, cv::IMWRITE_PNG_STRATEGY_DEFAULT, 1), 64));
  for (std::size_t cut = 0; cut < good.size(); cut += 97)
    EXPECT_FALSE(DecodePngTile(good.substr(0, cut), 64));
  for (std::size_t at = 8; at < good.size() - 12; at += 101) {
    std::string bent = good;
    bent[at] = static_cast<char>(bent[at] ^ 0x10);
    EXPECT_FALSE(DecodePngTile(bent, 64)) << "byte " << at;
  }
}

}  // namespace
}  // namespace skyquilt::image
