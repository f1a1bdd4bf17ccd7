// Pictures whose samples are more than bytes: which are drawn, in which range, and which are refused.
#include "core/flight/photos/sample_format.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/flight/photos/photo_decoder.h"
#include "core/flight/photos/read_photo.h"
#include "tests/core/flight/synthetic_photo.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 40, kHeight = 30;
constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

ExifTable Tags(int bits, int channels, int format, int photometric) {
  ExifTable tags;
  const auto set = [&](std::uint16_t tag, int value) {
    tags.Set(ExifIfd::kImage, tag,
             {static_cast<std::uint16_t>(ExifType::kShort),
              1,
              false,
              {static_cast<std::uint8_t>(value & 255), static_cast<std::uint8_t>(value >> 8)}});
  };
  set(0x0102, bits);
  set(0x0106, photometric);
  set(0x0115, channels);
  set(0x0153, format);
  return tags;
}

// Rises evenly from `low` to `high` over the picture.
cv::Mat Slope(int type, double low, double high) {
  cv::Mat numbers(kHeight, kWidth, CV_64F);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x)
      numbers.at<double>(y, x) = low + (high - low) * (y * kWidth + x) / (kWidth * kHeight - 1);
  }
  cv::Mat picture;
  numbers.convertTo(picture, type);
  return picture;
}

Bytes Tiff(const cv::Mat& picture) {
  Bytes file;
  EXPECT_TRUE(cv::imencode(".tif", picture, file, {cv::IMWRITE_TIFF_COMPRESSION, 1}));
  return file;
}

// First and last grey of the picture.
std::pair<int, int> Ends(const image::DecodedImage& image) { return {image.rgb.front(), image.rgb.back()}; }

// The photos of one camera, on disk.
class SampleFiles : public ::testing::Test {
 protected:
  Photo Write(const std::string& name, const Bytes& bytes) {
    auto photo = ReadPhotoFromBytes(name, bytes);
    EXPECT_TRUE(photo.ok()) << photo.error().message;
    photo->path = folder_.Write(name, bytes);
    return *photo;
  }

  const test::TemporaryFolder folder_;
  const FilePhotoSource source_;
};

TEST(SampleFormatOfTiff, RefusesTilesFarLargerThanThePicture) {
  const auto with = [](int width, int height, int tile_width, int tile_height) {
    ExifTable tags = Tags(8, 3, 1, 2);
    for (const auto& [tag, value] : {std::pair{0x0100, width}, std::pair{0x0101, height},
                                     std::pair{0x0142, tile_width}, std::pair{0x0143, tile_height}}) {
      std::vector<std::uint8_t> bytes;
      for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
      tags.Set(ExifIfd::kImage, static_cast<std::uint16_t>(tag),
               {static_cast<std::uint16_t>(ExifType::kLong), 1, false, bytes});
    }
    return SampleFormatOfTiff(tags);
  };
  EXPECT_TRUE(with(100, 80, 512, 512));
  EXPECT_TRUE(with(4000, 3000, 256, 256));
  EXPECT_TRUE(with(30'000, 12'000, 4096, 4096));
  const Error refused = test::ErrorOf(with(30'000, 16, 16, 1 << 22));
  EXPECT_EQ(refused.code, ErrorCode::kUnsupportedFormat);
  EXPECT_THAT(refused.message, HasSubstr("16 x 4194304"));
}

TEST(SampleFormatOfTiff, TellsWhatIsDrawn) {
  EXPECT_EQ(SampleFormatOfTiff(Tags(8, 3, 1, 2))->kind, SampleKind::kBytes);
  EXPECT_EQ(SampleFormatOfTiff(Tags(16, 1, 1, 1))->kind, SampleKind::kLevels);
  EXPECT_EQ(SampleFormatOfTiff(Tags(12, 1, 1, 1))->kind, SampleKind::kLevels);
  EXPECT_EQ(SampleFormatOfTiff(Tags(16, 3, 1, 2))->kind, SampleKind::kColourLevels);
  EXPECT_EQ(SampleFormatOfTiff(Tags(16, 1, 2, 1))->kind, SampleKind::kSigned);
  EXPECT_EQ(SampleFormatOfTiff(Tags(32, 1, 3, 1))->kind, SampleKind::kFloating);
  EXPECT_EQ(SampleFormatOfTiff(Tags(64, 1, 3, 1))->kind, SampleKind::kFloating);
  EXPECT_EQ(SampleFormatOfTiff(ExifTable())->kind, SampleKind::kBytes) << "the decoder finds out";
  EXPECT_TRUE(SampleFormatOfTiff(Tags(16, 1, 1, 0))->zero_is_white);
}

TEST(SampleFormatOfTiff, RefusesByName) {
  const auto refusal = [](const ExifTable& tags) {
    const auto format = SampleFormatOfTiff(tags);
    if (format) return std::string("drawn");
    EXPECT_EQ(format.error().code, ErrorCode::kUnsupportedFormat);
    return format.error().message;
  };
  EXPECT_THAT(refusal(Tags(16, 1, 3, 1)), HasSubstr("16-bit floating point"));
  EXPECT_THAT(refusal(Tags(32, 3, 3, 2)), HasSubstr("32-bit floating point numbers in 3 bands"));
  EXPECT_THAT(refusal(Tags(32, 1, 1, 1)), HasSubstr("32-bit whole numbers"));
  EXPECT_THAT(refusal(Tags(64, 1, 6, 1)), HasSubstr("complex"));
  EXPECT_THAT(refusal(Tags(4, 1, 1, 1)), HasSubstr("4-bit whole numbers"));
  EXPECT_THAT(refusal(Tags(16, 5, 1, 1)), HasSubstr("5 bands in one file"));
  EXPECT_THAT(refusal(Tags(16, 3, 1, 1)), HasSubstr("no colours"));
}

TEST(ReadPhoto, LeavesOutByItsHeaderWhatCannotBeDrawn) {
  const Error photo = test::ErrorOf(
      ReadPhotoFromBytes("a.tif", Tiff(cv::Mat(kHeight, kWidth, CV_32FC3, cv::Scalar::all(1)))));
  EXPECT_THAT(photo.message, HasSubstr("32-bit floating point"));
}

TEST(RangeOf, SpreadsFewLevelsAndKeepsTheDepthOfMany) {
  const auto range = [](std::vector<float> values, SampleKind kind) {
    return *RangeOf(std::move(values), kind);
  };
  EXPECT_EQ(range({100, 4000}, SampleKind::kLevels).high, 4000.0) << "12 bits in 16";
  EXPECT_EQ(range({7000, 9000}, SampleKind::kLevels).low, 7000.0) << "a thermal camera";
  EXPECT_EQ(range({100, 16000}, SampleKind::kLevels).high, 16384.0) << "14 bits in 16";
  EXPECT_EQ(range({100, 60000}, SampleKind::kLevels).high, 65536.0);
  EXPECT_EQ(range({300, 900}, SampleKind::kColourLevels).high, 1024.0) << "10 bits in 16";
  EXPECT_EQ(range({300, 900}, SampleKind::kColourLevels).low, 0.0) << "colours stay what they are";
  EXPECT_EQ(range({-40, 120}, SampleKind::kSigned).low, -40.0);
  EXPECT_EQ(range({12.0F, kNotANumber, 45.0F}, SampleKind::kFloating).high, 45.0);
  EXPECT_GT(range({5, 5}, SampleKind::kFloating).high, 5.0) << "a picture of one number has a range too";
  EXPECT_FALSE(RangeOf({kNotANumber}, SampleKind::kFloating));
  EXPECT_FALSE(RangeOf({}, SampleKind::kLevels));
  std::vector<float> glints(5000, 1000.0F);
  glints[0] = 4095.0F;
  glints[1] = 500.0F;
  for (std::size_t i = 10; i < 1000; ++i) glints[i] = 600.0F;
  EXPECT_EQ(range(glints, SampleKind::kLevels).high, 1000.0) << "a glint does not count";
}

TEST(DecodePhotoBytes, DrawsEveryKindOfSampleFromBlackToWhite) {
  const auto ends = [](const Bytes& file) {
    const auto image = DecodePhotoBytes(file, kWidth, kHeight, 1);
    EXPECT_TRUE(image.ok()) << image.error().message;
    return image ? Ends(*image) : std::pair{-1, -1};
  };
  for (const Bytes& file :
       {Tiff(Slope(CV_32F, 12.0, 45.0)), Tiff(Slope(CV_64F, 0.02, 0.6)), Tiff(Slope(CV_16U, 0, 4095)),
        Tiff(Slope(CV_16U, 0, 1023)), Tiff(Slope(CV_16U, 7000, 9000)), Tiff(Slope(CV_16U, 0, 65535))}) {
    const auto [first, last] = ends(file);
    EXPECT_LE(first, 2);
    EXPECT_GE(last, 252);
  }
  const auto [first, last] = ends(Tiff(Slope(CV_16U, 0, 16383)));
  EXPECT_EQ(first, 0);
  EXPECT_GE(last, 252);
  Bytes png;
  ASSERT_TRUE(cv::imencode(".png", Slope(CV_16U, 0, 4095), png));
  EXPECT_GE(ends(png).second, 252);
}

TEST(DecodePhotoBytes, DrawsTwelveBitsOfColourInTheirColours) {
  const cv::Mat colour(kHeight, kWidth, CV_16UC3, cv::Scalar(800, 1600, 3200));
  for (const char* ending : {".tif", ".png"}) {
    Bytes file;
    ASSERT_TRUE(cv::imencode(ending, colour, file));
    const auto image = test::ValueOf(DecodePhotoBytes(file, kWidth, kHeight, 1));
    EXPECT_EQ(image.rgb[0], 200);
    EXPECT_EQ(image.rgb[1], 100);
    EXPECT_EQ(image.rgb[2], 50);
  }
}

TEST(DecodePhotoBytes, FindsTheDepthByEveryColourButNotByOpacity) {
  // As large that every third number is looked at: of blue alone, were the colours not met evenly.
  constexpr int kSide = 256;
  Bytes file;
  ASSERT_TRUE(cv::imencode(".tif", cv::Mat(kSide, kSide, CV_16UC3, cv::Scalar(100, 100, 3200)), file));
  auto image = DecodePhotoBytes(file, kSide, kSide, 1);
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(image->rgb[0], 200);
  ASSERT_TRUE(
      cv::imencode(".png", cv::Mat(kHeight, kWidth, CV_16UC4, cv::Scalar(800, 1600, 3200, 65535)), file));
  image = DecodePhotoBytes(file, kWidth, kHeight, 1);
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_EQ(image->rgb[0], 200);
  EXPECT_EQ(image->rgb[2], 50);
}

TEST(DecodePhotoBytes, DrawsNumbersWithASign) {
  const cv::Mat numbers = Slope(CV_16S, -500.0, 3000.0);
  Bytes file = Tiff(cv::Mat(kHeight, kWidth, CV_16U, numbers.data));
  // The same bits, said to be signed: SampleFormat 2.
  const Bytes is_unsigned{0x53, 0x01, 0x03, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x00};
  const auto tag = std::search(file.begin(), file.end(), is_unsigned.begin(), is_unsigned.end());
  ASSERT_NE(tag, file.end());
  *(tag + 8) = 2;
  EXPECT_EQ(ReadPhotoFromBytes("a.tif", file)->sample_kind, SampleKind::kSigned);
  const auto image = test::ValueOf(DecodePhotoBytes(file, kWidth, kHeight, 1));
  EXPECT_LE(image.rgb.front(), 2);
  EXPECT_GE(image.rgb.back(), 252);
}

TEST(DecodePhotoBytes, DrawsWhatWasNotMeasuredBlack) {
  cv::Mat picture = Slope(CV_32F, 12.0, 45.0);
  picture.at<float>(0, 3) = kNotANumber;
  for (int x = 0; x < kWidth; ++x) picture.at<float>(10, x) = -9999.0F;
  for (int x = 0; x < kWidth; ++x) picture.at<float>(11, x) = -std::numeric_limits<float>::max();
  const auto image = test::ValueOf(DecodePhotoBytes(Tiff(picture), kWidth, kHeight, 1));
  EXPECT_EQ(image.Row(0)[3 * 3], 0);
  EXPECT_EQ(image.Row(10)[0], 0);
  EXPECT_EQ(image.Row(11)[0], 0);
  EXPECT_LE(image.Row(0)[0], 2) << "the range is that of what was measured";
  EXPECT_GE(image.rgb.back(), 252);
  const cv::Mat nothing(kHeight, kWidth, CV_32F, cv::Scalar(kNotANumber));
  EXPECT_THAT(test::ErrorOf(DecodePhotoBytes(Tiff(nothing), kWidth, kHeight, 2)).message,
              HasSubstr("holds no measurement"));
}

TEST_F(SampleFiles, OneCameraIsDrawnInOneRangeWhateverTheThreads) {
  std::vector<Photo> photos, others;
  for (int i = 0; i < 20; ++i) {
    // Each photo shows a part of the range: the first 12 to 24, the last 33 to 45.
    const double low = 12.0 + 21.0 * i / 19;
    photos.push_back(Write("T" + std::to_string(i) + ".tif", Tiff(Slope(CV_32F, low, low + 12.0))));
  }
  others = photos;
  ChooseSampleRanges(photos, source_, 1);
  ChooseSampleRanges(others, source_, 4);
  ASSERT_TRUE(photos[0].sample_range);
  EXPECT_NEAR(photos[0].sample_range->low, 12.0, 0.5);
  EXPECT_NEAR(photos[0].sample_range->high, 45.0, 1.5);
  for (std::size_t i = 0; i < photos.size(); ++i) {
    EXPECT_EQ(photos[i].sample_range->low, photos[0].sample_range->low);
    EXPECT_EQ(others[i].sample_range->high, photos[0].sample_range->high);
  }
  // The same temperature is the same grey in each.
  const auto first = source_.Decode(photos[0], 1), last = source_.Decode(photos[10], 1);
  ASSERT_TRUE(first.ok() && last.ok());
  EXPECT_NEAR(Ends(*first).second, 256.0 * 12.0 / 33.0, 6.0);
  EXPECT_NEAR(Ends(*last).first, 256.0 * (21.0 * 10 / 19) / 33.0, 6.0);
}

TEST_F(SampleFiles, BytesAndDamageHaveNoRange) {
  std::vector<Photo> photos{Write("a.tif", Tiff(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(7)))),
                            Write("b.tif", Tiff(Slope(CV_32F, 0.0, 1.0)))};
  std::filesystem::remove(photos[1].path);
  ChooseSampleRanges(photos, source_, 2);
  EXPECT_FALSE(photos[0].sample_range);
  EXPECT_FALSE(photos[1].sample_range);
  EXPECT_FALSE(source_.SampleValues(photos[0], 10).ok());
}

}  // namespace
}  // namespace skyquilt::flight
