#include "core/flight/metadata/capture_time.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

namespace skyquilt::flight {
namespace {

constexpr std::int64_t kMicrosPerSecond = 1000000;

UtcTime InUtc(const ExifTime& time) {
  return time.clock_minus_utc ? UtcTime(time.as_written - *time.clock_minus_utc) : time.as_written;
}

}  // namespace

CaptureTime ChooseCaptureTime(const ExifRecord& exif, const XmpTags& xmp, std::vector<std::string>& notes) {
  for (const std::string_view name : {"drone-dji:UTCAtExposure", "sensefly:UTCTime"}) {
    if (const auto time = ParseExifTime(xmp.Text(name))) return {InUtc(*time), false};
  }
  if (exif.taken_at && exif.clock_minus_utc) return {UtcTime(*exif.taken_at - *exif.clock_minus_utc), false};
  if (exif.taken_at && exif.gps_time) {
    // Zones are quarters of an hour; what is left over is the error of one of the clocks.
    constexpr std::int64_t kQuarter = 900 * kMicrosPerSecond;
    constexpr std::int64_t kAgreed = 5 * kMicrosPerSecond;
    constexpr std::int64_t kWidestZone = std::int64_t{15} * 3600 * kMicrosPerSecond;
    const std::int64_t ahead = (*exif.taken_at - *exif.gps_time).count();
    const auto quarters = static_cast<std::int64_t>(std::llround(static_cast<double>(ahead) / kQuarter));
    const std::int64_t left_over = ahead - quarters * kQuarter;
    if (std::abs(ahead) <= kWidestZone && std::abs(left_over) <= kAgreed) {
      return {UtcTime(*exif.taken_at - std::chrono::microseconds(quarters * kQuarter)), false};
    }
    notes.push_back("The camera's clock and the GPS time disagree; the GPS time was taken.");
    return {exif.gps_time, false};
  }
  if (exif.gps_time) return {exif.gps_time, false};
  if (exif.taken_at) return {exif.taken_at, true};
  for (const std::string_view name : {"exif:DateTimeOriginal", "xmp:CreateDate"}) {
    if (const auto time = ParseExifTime(xmp.Text(name))) return {InUtc(*time), !time->clock_minus_utc};
  }
  return {};
}

}  // namespace skyquilt::flight
