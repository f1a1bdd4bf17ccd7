#include "core/image/picture_codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>
#include <string>

#include "tests/support/bytes_of.h"
#include "tests/support/long_png.h"
#include "tests/support/value_of.h"

namespace skyquilt::image {
namespace {

using test::Text;

// Smooth colours; alpha grows from nothing at the left to full at the right.
RgbaImage Painted(int width_px, int height_px) {
  RgbaImage image = RgbaImage::Transparent(width_px, height_px);
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      std::uint8_t* pixel = image.Pixel(x, y);
      pixel[0] = static_cast<std::uint8_t>(2 * x);
      pixel[1] = static_cast<std::uint8_t>(3 * y);
      pixel[2] = static_cast<std::uint8_t>(x + y);
      pixel[3] = static_cast<std::uint8_t>(255 * x / (width_px - 1));
    }
  }
  return image;
}

TEST(PictureCodec, GivesPngBackToTheByte) {
  for (const auto& [width_px, height_px] : {std::pair{64, 64}, std::pair{50, 30}}) {
    const RgbaImage image = Painted(width_px, height_px);
    for (const auto& bytes : {EncodePicture(image, PictureFormat::kPng), EncodePlainPng(image)}) {
      EXPECT_EQ(PictureFormatOf(Text(bytes)), PictureFormat::kPng);
      const auto decoded = test::ValueOf(DecodePicture(Text(bytes)));
      EXPECT_EQ(decoded.width_px, width_px);
      EXPECT_EQ(decoded.height_px, height_px);
      EXPECT_EQ(decoded.rgba, image.rgba);
    }
  }
}

TEST(PictureCodec, KeepsTheAlphaOfWebpAndLaysJpegOnWhite) {
  const RgbaImage image = Painted(64, 48);
  const auto webp = DecodePicture(Text(EncodePicture(image, PictureFormat::kWebp)));
  const auto jpeg = DecodePicture(Text(EncodePicture(image, PictureFormat::kJpeg)));
  ASSERT_TRUE(webp);
  ASSERT_TRUE(jpeg);
  for (const int x : {20, 40, 63}) {
    EXPECT_EQ(webp->Pixel(x, 24)[3], image.Pixel(x, 24)[3]);
    EXPECT_EQ(jpeg->Pixel(x, 24)[3], 255);
    for (int c = 0; c < 3; ++c) {
      const int color = image.Pixel(x, 24)[c], alpha = image.Pixel(x, 24)[3];
      EXPECT_NEAR(webp->Pixel(x, 24)[c], color, 14);
      EXPECT_NEAR(jpeg->Pixel(x, 24)[c], (color * alpha + 255 * (255 - alpha)) / 255, 10);
    }
  }
}

TEST(PictureFormat, EachOfTheTableIsWrittenReadAndRecognised) {
  std::set<std::string> words, types;
  std::set<int> of_pmtiles, of_mbtiles;
  for (const PictureFormatRow& row : kPictureFormats) {
    const auto bytes = EncodePicture(Painted(32, 32), row.format);
    EXPECT_EQ(PictureFormatOf(Text(bytes)), row.format) << row.name;
    EXPECT_TRUE(DecodePicture(Text(bytes))) << row.name;
    EXPECT_EQ(PictureFormatNamed(row.extension), row.format);
    EXPECT_EQ(PictureFormatNamed(row.name), row.format);
    if (row.pmtiles_type > 0) {
      EXPECT_EQ(PictureFormatOfPmtiles(row.pmtiles_type), row.format);
    }
    EXPECT_EQ(PictureFormatOfMbtiles(MbtilesCodeOf(row.format)), row.format);
    EXPECT_TRUE(words.insert(row.extension).second && types.insert(row.content_type).second) << row.name;
    EXPECT_TRUE(row.pmtiles_type == 0 || of_pmtiles.insert(row.pmtiles_type).second) << row.name;
    EXPECT_TRUE(of_mbtiles.insert(row.mbtiles_code).second);
  }
  EXPECT_EQ(PictureFormatOf(std::string_view("RIFF\x10\0\0\0WEB", 11)), std::nullopt);
  EXPECT_EQ(PictureFormatNamed("PNG"), std::nullopt);  // addresses are written as they stand
  const std::string listed = ListedFormats(&PictureFormatRow::extension, ".");
  EXPECT_TRUE(listed.starts_with(".png, .jpg")) << listed;
  EXPECT_TRUE(listed.ends_with(std::string(" and .") + kPictureFormats.back().extension)) << listed;
}

TEST(PictureFormat, SaysWhetherAWebpHasAlpha) {
  RgbaImage image = Painted(64, 48);
  const auto lossy = EncodeWebp(RowsOf(image), 80.0F);
  EXPECT_TRUE(IsWebpWithAlpha(Text(lossy)));
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
  EXPECT_FALSE(IsWebpWithAlpha(Text(EncodeWebp(RowsOf(image), 80.0F))));
  cv::Mat colors(20, 30, CV_8UC4, cv::Scalar(10, 200, 30, 255));
  std::vector<std::uint8_t> lossless;
  cv::imencode(".webp", colors, lossless, {cv::IMWRITE_WEBP_QUALITY, 101});
  EXPECT_EQ(Text(lossless).substr(12, 4), "VP8L");
  EXPECT_FALSE(IsWebpWithAlpha(Text(lossless)));
  colors.at<cv::Vec4b>(3, 3)[3] = 7;
  cv::imencode(".webp", colors, lossless, {cv::IMWRITE_WEBP_QUALITY, 101});
  EXPECT_TRUE(IsWebpWithAlpha(Text(lossless)));
  for (const std::vector<std::uint8_t>& whole : {lossy, lossless}) {
    for (std::size_t size = 0; size <= 20; ++size) EXPECT_FALSE(IsWebpWithAlpha(Text(whole).substr(0, size)));
  }
  EXPECT_FALSE(IsWebpWithAlpha(Text(EncodePicture(image, PictureFormat::kPng))));
}

TEST(PictureCodec, EncodesRowsWithinALargerPicture) {
  const RgbaImage image = Painted(64, 64);
  const PixelRows part{image.Pixel(16, 32), 32, 16, 4, 4 * 64};
  const auto decoded = test::ValueOf(DecodePicture(Text(EncodeJpeg(part, 95))));
  EXPECT_EQ(decoded.width_px, 32);
  EXPECT_EQ(decoded.height_px, 16);
  EXPECT_NEAR(decoded.Pixel(8, 8)[0], image.Pixel(24, 40)[0], 6);
  EXPECT_NEAR(decoded.Pixel(8, 8)[1], image.Pixel(24, 40)[1], 6);
}

TEST(PictureCodec, ReadsWhatOthersWrite) {
  cv::Mat grey(20, 30, CV_16UC1, cv::Scalar(200 << 8));
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", grey, bytes);
  const auto decoded = test::ValueOf(DecodePicture(Text(bytes)));
  EXPECT_EQ(decoded.width_px, 30);
  EXPECT_EQ(decoded.Pixel(3, 3)[3], 255);
  EXPECT_EQ(decoded.Pixel(3, 3)[0], decoded.Pixel(3, 3)[2]);
}

TEST(PictureCodec, EndsWhatIsMadeToKeepADecoderBusy) {
  for (const std::uint32_t height_px : {64U, 48U}) {  // a tile, and another picture
    const std::size_t row_bytes = height_px * (1 + 4 * 64);
    EXPECT_TRUE(DecodePicture(Text(test::LongPng({64, height_px, 8, 6, 0}, row_bytes, 0))));
    EXPECT_EQ(DecodePicture(Text(test::LongPng({64, height_px, 8, 6, 0}, row_bytes, 300'000))).error().code,
              ErrorCode::kCorrupt);
  }
  // The last scan of a JPEG again and again.
  std::vector<std::uint8_t> jpeg;
  ASSERT_TRUE(cv::imencode(".jpg", cv::Mat(48, 64, CV_8UC3, cv::Scalar(10, 90, 200)), jpeg,
                           {cv::IMWRITE_JPEG_PROGRESSIVE, 1}));
  EXPECT_TRUE(DecodePicture(Text(jpeg)));
  const std::vector<std::uint8_t> start{0xFF, 0xDA}, end{0xFF, 0xD9};
  const std::vector<std::uint8_t> scan(std::find_end(jpeg.begin(), jpeg.end(), start.begin(), start.end()),
                                       jpeg.end() - 2);
  jpeg.resize(jpeg.size() - 2);
  for (int i = 0; i < 600; ++i) jpeg.insert(jpeg.end(), scan.begin(), scan.end());
  jpeg.insert(jpeg.end(), end.begin(), end.end());
  EXPECT_EQ(DecodePicture(Text(jpeg)).error().code, ErrorCode::kCorrupt);
  // A WebP has no more pixels than its header: what stands behind them is passed over.
  std::vector<std::uint8_t> webp = EncodePicture(Painted(64, 48), PictureFormat::kWebp);
  webp.resize(webp.size() + 300'000);
  const auto decoded = DecodePicture(Text(webp));
  EXPECT_TRUE(!decoded || (decoded->width_px == 64 && decoded->height_px == 48));
}

TEST(PictureCodec, RefusesWhatIsDamagedOrTooLarge) {
  EXPECT_EQ(DecodePicture("").error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(DecodePicture("GIF89a").error().code, ErrorCode::kCorrupt);
  for (const auto format : {PictureFormat::kJpeg, PictureFormat::kPng, PictureFormat::kWebp}) {
    const std::vector<std::uint8_t> bytes = EncodePicture(Painted(64, 64), format);
    EXPECT_FALSE(DecodePicture(Text(bytes).substr(0, 20)));
    EXPECT_FALSE(DecodePicture(Text(bytes).substr(0, bytes.size() / 2)));
    const std::vector<std::uint8_t> wide =
        EncodePicture(RgbaImage::Transparent(kMaxPictureSidePx + 1, 1), format);
    EXPECT_EQ(DecodePicture(Text(wide)).error().code, ErrorCode::kTooLarge);
  }
}

}  // namespace
}  // namespace skyquilt::image
