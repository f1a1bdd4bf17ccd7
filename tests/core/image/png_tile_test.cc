#include "core/image/png_tile.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>

namespace skyquilt::image {
namespace {

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
