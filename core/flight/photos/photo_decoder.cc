#include "core/flight/photos/photo_decoder.h"

#include <algorithm>
#include <cstdlib>
#include <new>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/metadata/exif_table.h"
#include "core/flight/metadata/flir_record.h"
#include "core/flight/photos/jpeg_segments.h"
#include "core/flight/photos/sample_format.h"
#include "core/flight/remarks/because.h"
#include "core/image/decode_errors.h"
#include "core/image/jpeg_decoder.h"
#include "core/image/png_decoder.h"

namespace skyquilt::flight {
namespace {

using image::DecodedImage;
using image::DecodedPart;

int CeilDiv(int a, int b) { return (a + b - 1) / b; }

// The tag by which a TIFF asks to be turned: OpenCV does so whatever its flags say.
std::optional<ExifValue> TurnOf(const std::vector<std::uint8_t>& bytes) {
  constexpr std::uint16_t kOrientationTag = 0x0112;
  if (!IsTiff(bytes)) return std::nullopt;
  MemoryBytes source(bytes);
  const auto tags = ReadTiffTags(source);
  const ExifValue* orientation = tags ? tags->Find(ExifIfd::kImage, kOrientationTag) : nullptr;
  if (orientation == nullptr || orientation->count != 1 || orientation->Number() == 1.0) return std::nullopt;
  // In its entry: elsewhere it may lie over any other part of the file, such as its size.
  constexpr std::size_t kEntryBytes = 4;
  if (orientation->bytes.size() > kEntryBytes) return std::nullopt;
  return *orientation;
}

// With 1 in place of what it asks.
std::vector<std::uint8_t> WithoutTurn(std::vector<std::uint8_t> tiff, const ExifValue& turn) {
  std::uint8_t* const value = tiff.data() + turn.offset;
  std::fill_n(value, turn.bytes.size(), std::uint8_t{0});
  value[turn.is_big_endian ? turn.bytes.size() - 1 : 0] = 1;
  return tiff;
}

// As stored, or as OpenCV's `flags` ask.
Result<cv::Mat> ReadByOpenCv(const std::vector<std::uint8_t>& bytes, int width_px, int height_px, int flags) {
  // What is wrong is said in the error, not on the terminal.
  static const auto before = cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  static_cast<void>(before);
  SKYQUILT_TRY(image::CheckPngEnds(bytes));
  const std::optional<ExifValue> turn = TurnOf(bytes);
  const std::vector<std::uint8_t> unturned = turn ? WithoutTurn(bytes, *turn) : std::vector<std::uint8_t>();
  cv::Mat picture;
  try {
    picture = cv::imdecode(turn ? unturned : bytes, flags | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return image::PictureDamaged(error.what());
  }
  if (picture.empty()) return image::PictureDamaged("no picture came out");
  if (picture.cols != width_px || picture.rows != height_px) return image::PictureChanged();
  return picture;
}

// What the header says of the samples; a picture that says nothing of use is left to the decoder.
SampleFormat FormatOf(const std::vector<std::uint8_t>& bytes) {
  if (image::IsPng(bytes)) return {SampleKindOfPng(bytes), false, std::nullopt};
  MemoryBytes source(bytes);
  const auto tags = ReadTiffTags(source);
  const auto format = tags ? SampleFormatOfTiff(*tags) : Result<SampleFormat>(tags.error());
  return format ? *format : SampleFormat();
}

// Numbers below any temperature or reflectance, and beyond any, mark what was not measured, tag or no tag.
bool IsMeasured(double value, const SampleFormat& format) {
  constexpr double kMin = -9998.0, kMax = 1e30;
  return value > kMin && value < kMax && value != format.no_data;
}

// Evenly over the picture's rows, each offset so that columns and colours are met evenly too.
std::vector<float> ValuesOf(const cv::Mat& stored, const SampleFormat& format, std::size_t most) {
  cv::Mat one_channel = stored.reshape(1), row;
  const auto channels = static_cast<std::size_t>(stored.channels());
  std::size_t step = std::max<std::size_t>(1, one_channel.total() / most);
  while (std::gcd(step, channels) > 1) ++step;
  std::vector<float> values;
  values.reserve(one_channel.total() / step + 1);
  const auto columns = static_cast<std::size_t>(one_channel.cols);
  for (std::size_t y = 0, at = 0; y < static_cast<std::size_t>(one_channel.rows); ++y) {
    one_channel.row(static_cast<int>(y)).convertTo(row, CV_32F);
    for (; at < (y + 1) * columns; at += step) {
      constexpr std::size_t kWithOpacity = 4;
      if (channels == kWithOpacity && at % kWithOpacity == kWithOpacity - 1) continue;
      const float value = row.at<float>(static_cast<int>(at - y * columns));
      if (IsMeasured(value, format)) values.push_back(value);
    }
  }
  return values;
}

// Samples that are more than bytes, in colours of eight bits. What was not measured is black.
cv::Mat EightBits(const cv::Mat& stored, const SampleFormat& format, std::optional<SampleRange> range) {
  if (!range) range = RangeOf(ValuesOf(stored, format, kSampleValues), format.kind);
  if (!range) range.emplace();
  constexpr double kLevels = 256.0, kRoundDown = -0.498;
  const double scale = kLevels / (range->high - range->low);
  cv::Mat eight, bgr;
  stored.convertTo(eight, CV_8U, scale, kRoundDown - scale * range->low);
  if (format.zero_is_white) cv::bitwise_not(eight, eight);
  if (format.no_data && stored.channels() == 1) eight.setTo(0, stored == *format.no_data);
  if (stored.channels() == 3) return eight;
  cv::cvtColor(eight, bgr, stored.channels() == 1 ? cv::COLOR_GRAY2BGR : cv::COLOR_BGRA2BGR);
  return bgr;
}

// Whole, as stored, of samples that are more than bytes.
Result<cv::Mat> ReadStored(const std::vector<std::uint8_t>& bytes, int width_px, int height_px,
                           SampleKind kind) {
  SKYQUILT_TRY_ASSIGN(cv::Mat stored, ReadByOpenCv(bytes, width_px, height_px, cv::IMREAD_UNCHANGED));
  const bool is_colour = kind == SampleKind::kColourLevels;
  if (stored.depth() == CV_8U || (stored.channels() == 1) == is_colour || stored.channels() == 2)
    return image::PictureDamaged("the samples are not of the kind that the header says");
  return stored;
}

Result<DecodedImage> DecodeByOpenCv(const std::vector<std::uint8_t>& bytes, int width_px, int height_px,
                                    int denominator, const std::optional<SampleRange>& range) {
  const SampleFormat format = FormatOf(bytes);
  cv::Mat bgr;
  if (format.kind == SampleKind::kBytes) {
    SKYQUILT_TRY_ASSIGN(bgr, ReadByOpenCv(bytes, width_px, height_px, cv::IMREAD_COLOR));
  } else {
    SKYQUILT_TRY_ASSIGN(const cv::Mat stored, ReadStored(bytes, width_px, height_px, format.kind));
    const bool may_lack_numbers = format.kind == SampleKind::kFloating || format.kind == SampleKind::kSigned;
    if (may_lack_numbers && ValuesOf(stored, format, kSampleValues).empty()) {
      return Because(ErrorCode::kCorrupt, RemarkCode::kPictureWithoutNumbers);
    }
    bgr = EightBits(stored, format, range);
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
  const SampleFormat format = FormatOf(bytes);
  if (image::IsPng(bytes) && format.kind == SampleKind::kBytes)
    return image::PngWorkBytes(bytes, width_px, height_px);
  const std::int64_t copy_bytes = TurnOf(bytes) ? static_cast<std::int64_t>(bytes.size()) : 0;
  // OpenCV's picture, its samples of 16 bits (four channels) or 64 (one), and ours.
  return copy_bytes + (format.kind == SampleKind::kBytes ? 9 : 18) * pixels;
}

Error NeedsTooMuch(std::int64_t needed_bytes, std::int64_t max_bytes) {
  constexpr double kMib = 1 << 20;
  return Because(ErrorCode::kTooLarge, {RemarkCode::kPictureTakesTooMuch,
                                        {{"needed_mib", static_cast<double>(needed_bytes) / kMib},
                                         {"left_mib", static_cast<double>(max_bytes) / kMib}}});
}

Result<void> CheckMemory(const std::vector<std::uint8_t>& bytes, int width_px, int height_px,
                         std::int64_t max_bytes) {
  const std::int64_t needed_bytes =
      static_cast<std::int64_t>(bytes.size()) + WorkBytes(bytes, width_px, height_px);
  if (needed_bytes > max_bytes) return NeedsTooMuch(needed_bytes, max_bytes);
  return {};
}

Result<std::vector<std::uint8_t>> ReadFile(const Photo& photo, std::int64_t max_bytes) {
  SKYQUILT_TRY_ASSIGN(auto source, OpenFileBytes(photo.path));
  const std::uint64_t size = source->size();
  if (size > static_cast<std::uint64_t>(max_bytes))
    return NeedsTooMuch(static_cast<std::int64_t>(std::min<std::uint64_t>(size, INT64_MAX)), max_bytes);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  if (!source->Read(0, bytes)) {
    return Because(ErrorCode::kIo, RemarkCode::kPhotoUnread, photo.path.string());
  }
  return bytes;
}

std::uint16_t Swapped(std::uint16_t level) { return static_cast<std::uint16_t>((level << 8) | (level >> 8)); }

// Most cameras store levels in their PNG in the wrong byte order, and no tag says which do: in the right one
// neighbours are alike.
void PutInOrder(cv::Mat1w& levels) {
  std::int64_t as_stored = 0, swapped = 0;
  for (int y = 0; y < levels.rows; ++y) {
    const std::uint16_t* row = levels[y];
    for (int x = 1; x < levels.cols; ++x) {
      as_stored += std::abs(row[x] - row[x - 1]);
      swapped += std::abs(Swapped(row[x]) - Swapped(row[x - 1]));
    }
  }
  if (as_stored < swapped) return;
  for (std::uint16_t& level : levels) level = Swapped(level);
}

Result<cv::Mat1w> LevelsOfPng(const FlirRecord& record) {
  // The size stands in the first 24 bytes; nothing is decoded that says another one than the record.
  constexpr std::size_t kSizeAt = 16;
  if (record.picture.size() < kSizeAt + 8 ||
      BigEndian32(record.picture.data() + kSizeAt) != static_cast<std::uint32_t>(record.width_px) ||
      BigEndian32(record.picture.data() + kSizeAt + 4) != static_cast<std::uint32_t>(record.height_px))
    return image::PictureDamaged("the levels' PNG is of another size");
  SKYQUILT_TRY(image::CheckPngEnds(record.picture));
  cv::Mat decoded;
  try {
    decoded = cv::imdecode(record.picture, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return image::PictureDamaged(error.what());
  }
  if (decoded.type() != CV_16UC1 || decoded.cols != record.width_px || decoded.rows != record.height_px)
    return image::PictureDamaged("the levels' PNG is not grey of 16 bits");
  cv::Mat1w levels = decoded;
  PutInOrder(levels);
  return levels;
}

Result<cv::Mat1w> LevelsOf(const FlirRecord& record) {
  if (image::IsPng(record.picture)) return LevelsOfPng(record);
  const std::size_t pixels = static_cast<std::size_t>(record.width_px) * record.height_px;
  if (record.picture.size() < 2 * pixels) return image::PictureDamaged("levels are missing");
  cv::Mat1w levels(record.height_px, record.width_px);
  const std::uint8_t* bytes = record.picture.data();
  for (std::uint16_t& level : levels) {
    level = static_cast<std::uint16_t>(UnsignedAt(bytes, 2, record.is_big_endian));
    bytes += 2;
  }
  return levels;
}

// What the sensor of a FLIR camera stored of a radiometric JPEG, at the size of the picture for looking, over
// which both show the same. kUnsupportedFormat for a JPEG without such levels, or of another shape.
Result<image::SampleImage> DecodeThermalLevels(const std::vector<std::uint8_t>& jpeg, int width_px,
                                               int height_px) {
  MemoryBytes source(jpeg);
  SKYQUILT_TRY_ASSIGN(const JpegSegments segments, ScanJpegSegments(source));
  if (segments.flir.empty()) {
    return Because(ErrorCode::kUnsupportedFormat, RemarkCode::kThermalWithoutLevels);
  }
  SKYQUILT_TRY_ASSIGN(const FlirRecord record, ReadFlirRecord(source, segments.flir));
  SKYQUILT_TRY_ASSIGN(const cv::Mat1w levels, LevelsOf(record));
  constexpr double kMaxStretch = 1.03;
  const double stretch =
      static_cast<double>(width_px) * levels.rows / (static_cast<double>(height_px) * levels.cols);
  if (stretch > kMaxStretch || stretch < 1.0 / kMaxStretch) {
    return Because(ErrorCode::kUnsupportedFormat, RemarkCode::kThermalOfOtherShape);
  }
  image::SampleImage image{width_px, height_px, {}};
  image.samples.resize(static_cast<std::size_t>(width_px) * height_px);
  cv::Mat1w sized(height_px, width_px, image.samples.data());
  cv::resize(levels, sized, sized.size(), 0, 0, cv::INTER_LINEAR);
  return image;
}

// Decoders of pictures are below remarks.
template <typename Picture>
Result<Picture> Told(Result<Picture> decoded) {
  if (decoded || decoded.error().code != ErrorCode::kCorrupt || decoded.error().reason != nullptr)
    return decoded;
  Error error = decoded.error();
  error.reason = std::make_shared<const Remark>(RemarkCode::kPictureDamaged);
  return error;
}

}  // namespace

Result<DecodedPart> DecodePhotoPart(const std::vector<std::uint8_t>& bytes, int width_px, int height_px,
                                    int denominator, const std::optional<image::PixelBox>& box,
                                    PixelBytes memory, std::int64_t max_bytes,
                                    const std::optional<SampleRange>& range) {
  SKYQUILT_CHECK(denominator == 1 || denominator == 2 || denominator == 4 || denominator == 8,
                 "photos are decoded at 1, 1/2, 1/4 or 1/8");
  SKYQUILT_TRY(CheckMemory(bytes, width_px, height_px, max_bytes));
  if (IsJpeg(bytes))
    return Told(image::DecodeJpeg(bytes, width_px, height_px, denominator, box, std::move(memory)));
  if (image::IsPng(bytes) && SampleKindOfPng(bytes) == SampleKind::kBytes)
    return Told(image::DecodePng(bytes, width_px, height_px, denominator, box, std::move(memory)));
  SKYQUILT_TRY_ASSIGN(DecodedImage image,
                      Told(DecodeByOpenCv(bytes, width_px, height_px, denominator, range)));
  return DecodedPart{std::move(image)};
}

Result<image::SampleImage> DecodeSampleBytes(const std::vector<std::uint8_t>& bytes, int width_px,
                                             int height_px, std::int64_t max_bytes) {
  SKYQUILT_TRY(CheckMemory(bytes, width_px, height_px, max_bytes));
  if (IsJpeg(bytes)) return Told(DecodeThermalLevels(bytes, width_px, height_px));
  SKYQUILT_TRY_ASSIGN(cv::Mat stored, Told(ReadByOpenCv(bytes, width_px, height_px, cv::IMREAD_UNCHANGED)));
  if (stored.channels() != 1 || (stored.depth() != CV_16U && stored.depth() != CV_8U)) {
    return Because(ErrorCode::kUnsupportedFormat, RemarkCode::kBandOfOtherNumbers);
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
                                      denominator, std::nullopt, {}, max_bytes_, photo.sample_range));
  return std::move(whole.image);
}

Result<DecodedPart> FilePhotoSource::DecodePart(const Photo& photo, int denominator,
                                                const image::PixelBox& box, PixelBytes memory) const {
  SKYQUILT_TRY_ASSIGN(const auto bytes, ReadFile(photo, max_bytes_));
  return DecodePhotoPart(bytes, photo.intrinsics.width_px, photo.intrinsics.height_px, denominator, box,
                         std::move(memory), max_bytes_, photo.sample_range);
}

Result<std::vector<float>> FilePhotoSource::SampleValues(const Photo& photo, std::size_t most) const {
  SKYQUILT_TRY_ASSIGN(const auto bytes, ReadFile(photo, max_bytes_));
  const int width_px = photo.intrinsics.width_px, height_px = photo.intrinsics.height_px;
  const SampleFormat format = FormatOf(bytes);
  if (format.kind == SampleKind::kBytes) return PhotoSource::SampleValues(photo, most);
  SKYQUILT_TRY(CheckMemory(bytes, width_px, height_px, max_bytes_));
  SKYQUILT_TRY_ASSIGN(const cv::Mat stored, ReadStored(bytes, width_px, height_px, format.kind));
  return ValuesOf(stored, format, most);
}

Result<image::SampleImage> FilePhotoSource::DecodeSamples(const Photo& photo) const {
  SKYQUILT_TRY_ASSIGN(const auto bytes, ReadFile(photo, max_bytes_));
  return DecodeSampleBytes(bytes, photo.intrinsics.width_px, photo.intrinsics.height_px, max_bytes_);
}

}  // namespace skyquilt::flight
