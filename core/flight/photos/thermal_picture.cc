#include "core/flight/photos/thermal_picture.h"

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/try.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/metadata/flir_record.h"
#include "core/flight/photos/jpeg_segments.h"
#include "core/flight/remarks/because.h"
#include "core/image/decode_errors.h"
#include "core/image/png_decoder.h"

namespace skyquilt::flight {
namespace {

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

}  // namespace

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

}  // namespace skyquilt::flight
