// Decoding: sizes, colours, kinds of picture, and damage.
#include "core/flight/photos/photo_decoder.h"

#include <gmock/gmock.h>
#include <turbojpeg.h>

#include <algorithm>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "core/flight/photos/read_photo.h"
#include "tests/core/flight/synthetic_photo.h"
#include "tests/support/long_png.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

// Red grows to the right, green downwards, blue is constant: mirrored or swapped channels would show.
Bytes Ramp(int width_px, int height_px) {
  Bytes rgb;
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      rgb.push_back(static_cast<std::uint8_t>(20 + 200 * x / width_px));
      rgb.push_back(static_cast<std::uint8_t>(20 + 200 * y / height_px));
      rgb.push_back(60);
    }
  }
  return rgb;
}

Bytes Jpeg(const Bytes& pixels, int width_px, int height_px, int pixel_format, int subsampling) {
  tjhandle turbo = tjInitCompress();
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(tjCompress2(turbo, pixels.data(), width_px, 0, height_px, pixel_format, &buffer, &size,
                        subsampling, 95, 0),
            0)
      << tjGetErrorStr2(turbo);
  Bytes jpeg(buffer, buffer + size);
  tjFree(buffer);
  tjDestroy(turbo);
  return jpeg;
}

void ExpectRamp(const image::DecodedImage& image, int width_px, int height_px, int denominator) {
  ASSERT_EQ(image.width_px, (width_px + denominator - 1) / denominator);
  ASSERT_EQ(image.height_px, (height_px + denominator - 1) / denominator);
  ASSERT_EQ(image.rgb.size(), static_cast<std::size_t>(image.width_px) * image.height_px * 3);
  for (int y = 1; y + 1 < image.height_px; ++y) {
    for (int x = 1; x + 1 < image.width_px; ++x) {
      const std::uint8_t* pixel = image.Row(y) + 3 * x;
      const double source_x = denominator * (x + 0.5) - 0.5;
      const double source_y = denominator * (y + 0.5) - 0.5;
      ASSERT_NEAR(pixel[0], 20 + 200 * source_x / width_px, 8) << x << " " << y;
      ASSERT_NEAR(pixel[1], 20 + 200 * source_y / height_px, 8) << x << " " << y;
      ASSERT_NEAR(pixel[2], 60, 8) << x << " " << y;
    }
  }
}

TEST(DecodePhotoBytes, DecodesJpegAtEverySize) {
  constexpr int kWidth = 203, kHeight = 149;
  const Bytes jpeg = Jpeg(Ramp(kWidth, kHeight), kWidth, kHeight, TJPF_RGB, TJSAMP_422);
  for (const int denominator : {1, 2, 4, 8}) {
    SCOPED_TRACE(denominator);
    const auto image = test::ValueOf(DecodePhotoBytes(jpeg, kWidth, kHeight, denominator));
    ExpectRamp(image, kWidth, kHeight, denominator);
  }
}

TEST(DecodePhotoBytes, DecodesTiffAndPngAtEverySize) {
  constexpr int kWidth = 203, kHeight = 149;
  const Bytes rgb = Ramp(kWidth, kHeight);
  cv::Mat bgr(kHeight, kWidth, CV_8UC3);
  for (std::size_t i = 0; i < bgr.total(); ++i) {
    bgr.data[3 * i] = rgb[3 * i + 2];
    bgr.data[3 * i + 1] = rgb[3 * i + 1];
    bgr.data[3 * i + 2] = rgb[3 * i];
  }
  cv::Mat deep;
  bgr.convertTo(deep, CV_16UC3, 256.0);
  for (const char* ending : {".tif", ".png"}) {
    for (const cv::Mat& picture : {bgr, deep}) {
      Bytes file;
      ASSERT_TRUE(cv::imencode(ending, picture, file));
      const auto header = test::ValueOf(ReadPhotoFromBytes(ending, file));
      for (const int denominator : {1, 2, 4, 8}) {
        SCOPED_TRACE(std::string(ending) + " " + std::to_string(denominator));
        const auto image = test::ValueOf(
            DecodePhotoBytes(file, header.intrinsics.width_px, header.intrinsics.height_px, denominator));
        ExpectRamp(image, kWidth, kHeight, denominator);
      }
    }
  }
}

// The angles are those of the picture as it is stored; by itself OpenCV turns TIFFs by that tag.
TEST(DecodePhotoBytes, GivesATiffAsItIsStoredWhateverItsOrientation) {
  constexpr int kWidth = 40, kHeight = 30;
  std::vector<std::uint16_t> levels(std::size_t{kWidth} * kHeight);
  std::iota(levels.begin(), levels.end(), std::uint16_t{100});
  for (std::uint16_t orientation = 1; orientation <= 8; ++orientation) {
    SCOPED_TRACE(orientation);
    const ExifWriter tags = ExifWriter().Short(ExifIfd::kImage, 0x0112, orientation);
    const Bytes colour = TiffImage(tags, kWidth, kHeight, Ramp(kWidth, kHeight));
    ExpectRamp(test::ValueOf(DecodePhotoBytes(colour, kWidth, kHeight, 1)), kWidth, kHeight, 1);
    const Bytes band = BandTiff(tags, kWidth, kHeight, levels, "");
    EXPECT_EQ(test::ValueOf(DecodeSampleBytes(band, kWidth, kHeight)).samples, levels);
  }
}

TEST(DecodePhotoBytes, ChangesNothingOfATiffButItsOrientation) {
  constexpr int kWidth = 40, kHeight = 30;
  Bytes tiff = TiffImage(ExifWriter().Rational(ExifIfd::kImage, 0x0112, {{3, 1}}), kWidth, kHeight,
                         Ramp(kWidth, kHeight));
  const Bytes entry = {0x12, 0x01, 0x05, 0x00};
  const auto found = std::search(tiff.begin(), tiff.end(), entry.begin(), entry.end());
  ASSERT_NE(found, tiff.end());
  // Its value lies where the header says where the directory is.
  const Bytes offset = {4, 0, 0, 0};
  std::copy(offset.begin(), offset.end(), found + 8);
  ExpectRamp(test::ValueOf(DecodePhotoBytes(tiff, kWidth, kHeight, 1)), kWidth, kHeight, 1);
}

// Noise, so that every pixel that comes from elsewhere or is smoothed otherwise shows.
Bytes Noise(int width_px, int height_px) {
  std::mt19937 random(7);
  Bytes rgb(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px) * 3);
  for (std::uint8_t& value : rgb) value = static_cast<std::uint8_t>(random() >> 24);
  return rgb;
}

void ExpectPartsOf(const Bytes& file, int width_px, int height_px) {
  std::mt19937 random(11);
  for (const int denominator : {1, 2, 4, 8}) {
    const auto whole = test::ValueOf(DecodePhotoBytes(file, width_px, height_px, denominator));
    const auto below = [&](int end) { return static_cast<int>(random() % static_cast<unsigned>(end)); };
    for (int trial = 0; trial < 40; ++trial) {
      image::PixelBox box{below(whole.width_px), below(whole.height_px), 0, 0};
      box.right = box.left + 1 + below(whole.width_px - box.left);
      box.bottom = box.top + 1 + below(whole.height_px - box.top);
      SCOPED_TRACE(::testing::Message() << "1/" << denominator << ": " << box.left << " " << box.top << " "
                                        << box.right << " " << box.bottom);
      const auto part = test::ValueOf(DecodePhotoPart(file, width_px, height_px, denominator, box));
      const image::DecodedImage& image = part.image;
      ASSERT_TRUE((image::PixelBox{part.left_px, part.top_px, part.left_px + image.width_px,
                                   part.top_px + image.height_px}
                       .Contains(box)));
      ASSERT_EQ(image.rgb.size(), static_cast<std::size_t>(image.width_px) * image.height_px * 3);
      for (int y = box.top; y < box.bottom; ++y) {
        const std::uint8_t* there = image.Row(y - part.top_px) + 3 * (box.left - part.left_px);
        ASSERT_TRUE(std::equal(there, there + 3 * (box.right - box.left), whole.Row(y) + 3 * box.left)) << y;
      }
    }
  }
}

TEST(DecodePhotoPart, GivesThePixelsOfTheWhole) {
  constexpr int kWidth = 413, kHeight = 301;
  const Bytes rgb = Noise(kWidth, kHeight);
  for (const int subsampling : {TJSAMP_444, TJSAMP_422, TJSAMP_420, TJSAMP_440, TJSAMP_411, TJSAMP_GRAY}) {
    SCOPED_TRACE(subsampling);
    ExpectPartsOf(Jpeg(rgb, kWidth, kHeight, TJPF_RGB, subsampling), kWidth, kHeight);
  }
}

TEST(DecodePhotoPart, GivesThePixelsOfAProgressivePictureAndOfOneWithRestarts) {
  constexpr int kWidth = 413, kHeight = 301;
  Bytes rgb = Noise(kWidth, kHeight);
  const cv::Mat picture(kHeight, kWidth, CV_8UC3, rgb.data());
  for (const std::vector<int>& how : {std::vector<int>{cv::IMWRITE_JPEG_PROGRESSIVE, 1},
                                      std::vector<int>{cv::IMWRITE_JPEG_RST_INTERVAL, 5}}) {
    Bytes file;
    ASSERT_TRUE(cv::imencode(".jpg", picture, file, how));
    ExpectPartsOf(file, kWidth, kHeight);
  }
}

TEST(DecodePhotoPart, GivesThePartsOfOtherPictures) {
  Bytes rgb = Noise(203, 149), file;
  ASSERT_TRUE(cv::imencode(".png", cv::Mat(149, 203, CV_8UC3, rgb.data()), file));
  ExpectPartsOf(file, 203, 149);
}

TEST(DecodePhotoPart, AveragesAPngRowByRow) {
  const int width = 37, height = 21;  // the last row and column hang over
  Bytes rgb = Noise(width, height), file;
  cv::Mat bgr;
  cv::cvtColor(cv::Mat(height, width, CV_8UC3, rgb.data()), bgr, cv::COLOR_RGB2BGR);
  ASSERT_TRUE(cv::imencode(".png", bgr, file));
  for (const int d : {1, 2, 4, 8}) {
    const auto image = test::ValueOf(DecodePhotoBytes(file, width, height, d));
    for (int y = 0; y < image.height_px; ++y) {
      for (int x = 0; x < image.width_px; ++x) {
        for (int c = 0; c < 3; ++c) {
          int sum = 0;
          for (int k = 0; k < d * d; ++k) {
            const int from_x = std::min(x * d + k % d, width - 1),
                      from_y = std::min(y * d + k / d, height - 1);
            sum += rgb[static_cast<std::size_t>(3 * (from_y * width + from_x) + c)];
          }
          ASSERT_EQ(image.Row(y)[3 * x + c], (sum + d * d / 2) / (d * d)) << d << ": " << x << " " << y;
        }
      }
    }
  }
}

TEST(DecodePhotoBytes, ReadsEveryKindOfPng) {
  const cv::Mat grey(30, 40, CV_8U, cv::Scalar(90));
  cv::Mat deep(30, 40, CV_16UC3, cv::Scalar(10 << 8, 20 << 8, 30 << 8)),
      clear(30, 40, CV_8UC4, cv::Scalar(10, 20, 30, 77));
  deep.row(29).setTo(cv::Scalar::all(65535));  // of all 16 bits
  Bytes file;
  ASSERT_TRUE(cv::imencode(".png", grey, file));
  EXPECT_EQ(DecodePhotoBytes(file, 40, 30, 2)->rgb, PixelBytes(20 * 15 * 3, 90));
  for (const cv::Mat& picture : {deep, clear}) {
    ASSERT_TRUE(cv::imencode(".png", picture, file));
    const auto image = test::ValueOf(DecodePhotoBytes(file, 40, 30, 1));
    EXPECT_EQ(image.rgb[0], 30);
    EXPECT_EQ(image.rgb[1], 20);
    EXPECT_EQ(image.rgb[2], 10);
  }
  for (std::size_t length = 0; length + 12 < file.size(); length += 7)
    EXPECT_FALSE(
        DecodePhotoBytes(Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(length)), 40, 30, 1)
            .ok());
}

// Of libpng as of OpenCV, which would unpack all that comes and throw it away.
TEST(DecodePhotoBytes, EndsAPngThatGoesOnBehindItsRows) {
  struct Case {
    test::LongPngHeader header;
    std::size_t row_bytes;
  };
  const Case cases[] = {{{64, 48, 8, 2, 0}, 48 * (1 + 3 * 64)},                           // ours
                        {{8, 8, 8, 2, 1}, 4 + 4 + 7 + 2 * 7 + 2 * 13 + 4 * 13 + 4 * 25},  // interlaced
                        {{4, 1, 8, 2, 1}, 4 + 4 + 7},                                     // of three passes
                        {{64, 48, 16, 0, 0}, 48 * (1 + 2 * 64)}};                         // OpenCV's
  for (const Case& one : cases) {
    const int width_px = static_cast<int>(one.header.width_px);
    const int height_px = static_cast<int>(one.header.height_px);
    for (const std::size_t more : {std::size_t{0}, std::size_t{100}}) {
      const auto image =
          DecodePhotoBytes(test::LongPng(one.header, one.row_bytes, more), width_px, height_px, 1);
      EXPECT_TRUE(image.ok()) << width_px << " " << more << " " << image.error().detail;
    }
    const auto bomb =
        DecodePhotoBytes(test::LongPng(one.header, one.row_bytes, 300'000), width_px, height_px, 1);
    ASSERT_FALSE(bomb.ok()) << width_px << " " << int{one.header.depth};
    EXPECT_EQ(bomb.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(bomb.error().detail, ::testing::HasSubstr("go on"));
  }
}

TEST(DecodePhotoPart, RefusesWhatTakesMoreThanItMay) {
  Bytes rgb = Noise(640, 480), progressive, png;
  const cv::Mat picture(480, 640, CV_8UC3, rgb.data());
  ASSERT_TRUE(cv::imencode(".jpg", picture, progressive, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}));
  ASSERT_TRUE(cv::imencode(".png", picture, png));
  const Error refused = test::ErrorOf(DecodePhotoPart(progressive, 640, 480, 8, std::nullopt, {}, 1 << 20));
  EXPECT_EQ(refused.code, ErrorCode::kTooLarge);
  EXPECT_THAT(refused.message, ::testing::HasSubstr("--max-memory"));
  EXPECT_TRUE(DecodePhotoPart(progressive, 640, 480, 8, std::nullopt, {}, 4 << 20).ok());
  EXPECT_TRUE(DecodePhotoPart(png, 640, 480, 8, std::nullopt, {}, 1 << 20).ok());
}

TEST(DecodePhotoPart, ReadsNothingBelow) {
  const Bytes jpeg = Jpeg(Noise(320, 240), 320, 240, TJPF_RGB, TJSAMP_420);
  const Bytes cut(jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(jpeg.size() / 2));
  EXPECT_TRUE(DecodePhotoPart(cut, 320, 240, 1, image::PixelBox{0, 0, 320, 60}).ok());
  const Error below = test::ErrorOf(DecodePhotoPart(cut, 320, 240, 1, image::PixelBox{0, 180, 320, 240}));
  EXPECT_EQ(below.code, ErrorCode::kCorrupt);
}

TEST(DecodePhotoBytes, RefusesAPictureOfTooManyScans) {
  Bytes rgb = Noise(64, 48), file;
  ASSERT_TRUE(
      cv::imencode(".jpg", cv::Mat(48, 64, CV_8UC3, rgb.data()), file, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}));
  // The last scan again and again, before the end of the picture.
  const Bytes start{0xFF, 0xDA};
  const auto last = std::find_end(file.begin(), file.end(), start.begin(), start.end());
  const Bytes scan(last, file.end() - 2);
  Bytes bomb(file.begin(), file.end() - 2);
  for (int i = 0; i < 600; ++i) bomb.insert(bomb.end(), scan.begin(), scan.end());
  bomb.insert(bomb.end(), {0xFF, 0xD9});
  EXPECT_EQ(test::ErrorOf(DecodePhotoBytes(bomb, 64, 48, 1)).code, ErrorCode::kCorrupt);
}

// As phones write it ("Invalid SOS parameters for sequential JPEG").
TEST(DecodePhotoBytes, ReadsAJpegWhoseScanNamesAWrongRangeOfCoefficients) {
  Bytes jpeg = Jpeg(Ramp(64, 48), 64, 48, TJPF_RGB, TJSAMP_444);
  const auto image = test::ValueOf(DecodePhotoBytes(jpeg, 64, 48, 1));
  const Bytes start{0xFF, 0xDA};
  const auto scan = std::search(jpeg.begin(), jpeg.end(), start.begin(), start.end());
  constexpr std::ptrdiff_t kLastCoefficientAt = 12;
  ASSERT_GT(jpeg.end() - scan, kLastCoefficientAt);
  ASSERT_EQ(scan[kLastCoefficientAt], 63);
  scan[kLastCoefficientAt] = 0;
  const auto same = test::ValueOf(DecodePhotoBytes(jpeg, 64, 48, 1));
  EXPECT_TRUE(same.rgb == image.rgb);
}

// libjpeg warns: "unknown JFIF revision number".
TEST(DecodePhotoBytes, ReadsAJpegOfAVersionThatThereIsNot) {
  Bytes jpeg = Jpeg(Ramp(64, 48), 64, 48, TJPF_RGB, TJSAMP_444);
  const auto image = test::ValueOf(DecodePhotoBytes(jpeg, 64, 48, 1));
  constexpr std::size_t kVersionAt = 11;
  ASSERT_EQ(jpeg[kVersionAt - 2], 'F');
  ASSERT_EQ(jpeg[kVersionAt], 1);
  jpeg[kVersionAt] = 2;
  const auto same = test::ValueOf(DecodePhotoBytes(jpeg, 64, 48, 1));
  EXPECT_TRUE(same.rgb == image.rgb);
}

TEST(DecodePhotoBytes, TurnsGreyIntoRgb) {
  const Bytes jpeg = Jpeg(Bytes(64 * 48, 77), 64, 48, TJPF_GRAY, TJSAMP_GRAY);
  const auto image = test::ValueOf(DecodePhotoBytes(jpeg, 64, 48, 2));
  ASSERT_EQ(image.rgb.size(), 32u * 24u * 3u);
  for (const std::uint8_t value : image.rgb) ASSERT_NEAR(value, 77, 2);
}

TEST(DecodePhotoBytes, TurnsAdobesInvertedCmykIntoRgb) {
  Bytes cmyk;
  for (int i = 0; i < 64 * 48; ++i) cmyk.insert(cmyk.end(), {200, 100, 50, 255});
  const auto image = test::ValueOf(DecodePhotoBytes(Jpeg(cmyk, 64, 48, TJPF_CMYK, TJSAMP_444), 64, 48, 1));
  EXPECT_NEAR(image.rgb[0], 200, 4);
  EXPECT_NEAR(image.rgb[1], 100, 4);
  EXPECT_NEAR(image.rgb[2], 50, 4);
}

TEST(DecodePhotoBytes, RefusesEveryJpegThatIsCutOff) {
  const Bytes jpeg = Jpeg(Ramp(160, 120), 160, 120, TJPF_RGB, TJSAMP_420);
  for (std::size_t length = 0; length + 2 < jpeg.size(); length += 97) {
    const auto image = DecodePhotoBytes(Bytes(jpeg.begin(), jpeg.begin() + length), 160, 120, 1);
    ASSERT_FALSE(image.ok()) << length;
    EXPECT_EQ(image.error().code, ErrorCode::kCorrupt);
    EXPECT_THAT(image.error().message, ::testing::HasSubstr("Copy the file"));
  }
}

TEST(DecodePhotoBytes, RefusesAFileThatChangedSinceItsHeaderWasRead) {
  const Error image =
      test::ErrorOf(DecodePhotoBytes(Jpeg(Ramp(160, 120), 160, 120, TJPF_RGB, TJSAMP_420), 4000, 3000, 1));
  EXPECT_EQ(image.code, ErrorCode::kCorrupt);
}

TEST(DecodePhotoBytes, SurvivesDamagedTiffAndNonsense) {
  const Bytes whole = TiffImage(ExifWriter(), 64, 48, Bytes(64 * 48 * 3, 90));
  EXPECT_FALSE(DecodePhotoBytes(Bytes(whole.begin(), whole.begin() + 60), 64, 48, 1).ok());
  EXPECT_FALSE(DecodePhotoBytes({}, 64, 48, 1).ok());
  EXPECT_FALSE(DecodePhotoBytes(Bytes(1000, 'x'), 64, 48, 4).ok());
}

TEST(FilePhotoSource, NamesAFileThatIsGone) {
  Photo photo;
  photo.path = "/nonexistent/photo.jpg";
  EXPECT_EQ(test::ErrorOf(FilePhotoSource().Decode(photo, 1)).code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace skyquilt::flight
