#include "core/flight/photos/photo_decoder.h"

#include <fmt/core.h>

#include <algorithm>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/flight/metadata/exif_table.h"
#include "core/flight/photos/byte_source.h"
#include "core/flight/photos/read_photo.h"
#include "core/flight/photos/thermal_picture.h"
#include "core/image/decode_errors.h"
#include "core/image/jpeg_decoder.h"
#include "core/image/png_decoder.h"

namespace skyquilt::flight {
namespace {

using image::DecodedImage;
using image::DecodedPart;

int CeilDiv(int a, int b) { return (a + b - 1) / b; }

// As stored, or as OpenCV's `flags` ask.
Result<cv::Mat> ReadByOpenCv(const std::vector<std::uint8_t>& bytes, int width_px, int height_px, int flags) {
  cv::Mat picture;
  try {
    picture = cv::imdecode(bytes, flags | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return image::PictureDamaged(error.what());
  }
  if (picture.empty()) return image::PictureDamaged("no picture came out");
  if (picture.cols != width_px || picture.rows != height_px) return image::PictureChanged();
  return picture;
}

// Grey of sixteen bits to colours of eight. A thermal camera's levels fill a hundredth of them: those are
// spread, from what a thousandth of the pixels lies below to what a thousandth lies above.
cv::Mat EightBits(const cv::Mat& levels) {
  constexpr std::size_t kLevels = std::size_t{1} << 16;
  std::vector<std::int64_t> counts(kLevels, 0);
  for (int y = 0; y < levels.rows; ++y) {
    const std::uint16_t* row = levels.ptr<std::uint16_t>(y);
    for (int x = 0; x < levels.cols; ++x) ++counts[row[x]];
  }
  const std::int64_t rare = static_cast<std::int64_t>(levels.total()) / 1000;
  std::size_t low = 0, high = kLevels - 1;
  for (std::int64_t below = counts[low]; below <= rare && low < high; below += counts[low]) ++low;
  for (std::int64_t above = counts[high]; above <= rare && high > low; above += counts[high]) --high;
  constexpr double kNarrow = kLevels / 16.0, kMaxByte = 255.0;
  const auto range = static_cast<double>(high - low);
  cv::Mat eight, bgr;
  if (range >= kNarrow || range < 1.0) {
    constexpr double kRoundDown = -0.498;
    levels.convertTo(eight, CV_8U, 1.0 / 256.0, kRoundDown);
  } else {
    levels.convertTo(eight, CV_8U, kMaxByte / range, -kMaxByte / range * static_cast<double>(low));
  }
  cv::cvtColor(eight, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

bool IsGreyOf16Bits(const std::vector<std::uint8_t>& tiff) {
  constexpr std::uint16_t kBitsTag = 0x0102, kSamplesPerPixelTag = 0x0115;
  MemoryBytes source(tiff);
  const auto tags = ReadTiffTags(source);
  return tags && tags->Number(ExifIfd::kImage, kBitsTag) == 16.0 &&
         tags->Number(ExifIfd::kImage, kSamplesPerPixelTag).value_or(1.0) == 1.0;
}

Result<DecodedImage> DecodeByOpenCv(const std::vector<std::uint8_t>& bytes, int width_px, int height_px,
                                    int denominator) {
  const bool is_grey = IsGreyOf16Bits(bytes);
  SKYQUILT_TRY_ASSIGN(cv::Mat bgr, ReadByOpenCv(bytes, width_px, height_px,
                                                is_grey ? cv::IMREAD_UNCHANGED : cv::IMREAD_COLOR));
  if (is_grey) {
    if (bgr.type() != CV_16UC1) return image::PictureDamaged("the picture is not grey of 16 bits");
    bgr = EightBits(bgr);
  }
  if (denominator > 1) {
    const int width = CeilDiv(width_px, denominator);
    const int height = CeilDiv(height_px, denominator);
    cv::copyMakeBorder(bgr, bgr, 0, height * denominator - height_px, 0, width * denominator - width_px,
                       cv::BORDER_REPLICATE);
    cv::Mat smaller;
    cv::resize(bgr, smaller, cv::Size(width, height), 0, 0, cv::INTER_AREA);
    bgr = smaller;
  }
  DecodedImage image;
  image.width_px = bgr.cols;
  image.height_px = bgr.rows;
  image.rgb.resize(3 * bgr.total());
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, image.rgb.data());
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return image;
}

bool IsJpeg(const std::vector<std::uint8_t>& bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

// What a format that cannot be read by parts takes while it is decoded, beside the file's bytes.
std::int64_t WorkBytes(const std::vector<std::uint8_t>& bytes, int width_px, int height_px) {
  const std::int64_t pixels = std::int64_t{width_px} * height_px;
  if (IsJpeg(bytes)) return image::JpegWorkBytes(bytes, width_px, height_px);
  if (image::IsPng(bytes)) return image::PngWorkBytes(bytes, width_px, height_px);
  return 9 * pixels;  // OpenCV's picture, its samples of 16 bits, and ours
}

Error NeedsTooMuch(std::int64_t needed_bytes, std::int64_t max_bytes) {
  constexpr double kMib = 1 << 20;
  return {ErrorCode::kTooLarge,
          fmt::format(
              "Decoding the picture takes {:.0f} MiB, and {:.0f} MiB are left for it. Raise --max-memory, "
              "or save it as a JPEG that is not progressive.",
              static_cast<double>(needed_bytes) / kMib, static_cast<double>(max_bytes) / kMib),
          ""};
}

Result<std::vector<std::uint8_t>> ReadFile(const Photo& photo, std::int64_t max_bytes) {
  SKYQUILT_TRY_ASSIGN(auto source, OpenFileBytes(photo.path));
  const std::uint64_t size = source->size();
  if (size > static_cast<std::uint64_t>(max_bytes))
    return NeedsTooMuch(static_cast<std::int64_t>(std::min<std::uint64_t>(size, INT64_MAX)), max_bytes);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  if (!source->Read(0, bytes)) {
    return Error{ErrorCode::kIo, "The picture's file cannot be read from the disk.", photo.path.string()};
  }
  return bytes;
}

}  // namespace

Result<DecodedPart> DecodePhotoPart(const std::vector<std::uint8_t>& bytes, int width_px, int height_px,
                                    int denominator, const std::optional<image::PixelBox>& box,
                                    PixelBytes memory, std::int64_t max_bytes) {
  SKYQUILT_CHECK(denominator == 1 || denominator == 2 || denominator == 4 || denominator == 8,
                 "photos are decoded at 1, 1/2, 1/4 or 1/8");
  const std::int64_t needed_bytes =
      static_cast<std::int64_t>(bytes.size()) + WorkBytes(bytes, width_px, height_px);
  if (needed_bytes > max_bytes) return NeedsTooMuch(needed_bytes, max_bytes);
  if (IsJpeg(bytes))
    return image::DecodeJpeg(bytes, width_px, height_px, denominator, box, std::move(memory));
  if (image::IsPng(bytes))
    return image::DecodePng(bytes, width_px, height_px, denominator, box, std::move(memory));
  SKYQUILT_TRY_ASSIGN(DecodedImage image, DecodeByOpenCv(bytes, width_px, height_px, denominator));
  return DecodedPart{std::move(image)};
}

Result<image::SampleImage> DecodeSampleBytes(const std::vector<std::uint8_t>& bytes, int width_px,
                                             int height_px, std::int64_t max_bytes) {
  const std::int64_t needed_bytes =
      static_cast<std::int64_t>(bytes.size()) + WorkBytes(bytes, width_px, height_px);
  if (needed_bytes > max_bytes) return NeedsTooMuch(needed_bytes, max_bytes);
  if (IsJpeg(bytes)) return DecodeThermalLevels(bytes, width_px, height_px);
  SKYQUILT_TRY_ASSIGN(cv::Mat stored, ReadByOpenCv(bytes, width_px, height_px, cv::IMREAD_UNCHANGED));
  if (stored.channels() != 1 || (stored.depth() != CV_16U && stored.depth() != CV_8U)) {
    return Error{
        ErrorCode::kUnsupportedFormat,
        "The picture of a band has more than one channel, or numbers other than whole ones of 8 or 16 bits. "
        "Give the file as the camera wrote it.",
        ""};
  }
  image::SampleImage image{width_px, height_px, {}};
  image.samples.resize(stored.total());
  cv::Mat samples(height_px, width_px, CV_16UC1, image.samples.data());
  constexpr double kEightToSixteenBits = 257.0;
  stored.convertTo(samples, CV_16U, stored.depth() == CV_8U ? kEightToSixteenBits : 1.0);
  return image;
}

Result<DecodedImage> DecodePhotoBytes(const std::vector<std::uint8_t>& bytes, int width_px, int height_px,
                                      int denominator) {
  SKYQUILT_TRY_ASSIGN(DecodedPart whole,
                      DecodePhotoPart(bytes, width_px, height_px, denominator, std::nullopt));
  return std::move(whole.image);
}

Result<DecodedImage> FilePhotoSource::Decode(const Photo& photo, int denominator) const {
  SKYQUILT_TRY_ASSIGN(const auto bytes, ReadFile(photo, max_bytes_));
  SKYQUILT_TRY_ASSIGN(DecodedPart whole,
                      DecodePhotoPart(bytes, photo.intrinsics.width_px, photo.intrinsics.height_px,
                                      denominator, std::nullopt, {}, max_bytes_));
  return std::move(whole.image);
}

Result<DecodedPart> FilePhotoSource::DecodePart(const Photo& photo, int denominator,
                                                const image::PixelBox& box, PixelBytes memory) const {
  SKYQUILT_TRY_ASSIGN(const auto bytes, ReadFile(photo, max_bytes_));
  return DecodePhotoPart(bytes, photo.intrinsics.width_px, photo.intrinsics.height_px, denominator, box,
                         std::move(memory), max_bytes_);
}

Result<image::SampleImage> FilePhotoSource::DecodeSamples(const Photo& photo) const {
  SKYQUILT_TRY_ASSIGN(const auto bytes, ReadFile(photo, max_bytes_));
  return DecodeSampleBytes(bytes, photo.intrinsics.width_px, photo.intrinsics.height_px, max_bytes_);
}

}  // namespace skyquilt::flight
