#include "core/flight/metadata/capture_time.h"

#include <cmath>
#include <string_view>

namespace skyquilt::flight {
namespace {

constexpr std::int64_t kMicrosPerSecond = 1000000;

UtcTime InUtc(const ExifTime& time) {
  return time.clock_minus_utc ? UtcTime(time.as_written - *time.clock_minus_utc) : time.as_written;
}

// Zones are quarters of an hour; what is left over is the error of one of the clocks.
struct ClockStep {
  std::chrono::minutes zone;
  std::chrono::microseconds left_over;
};

std::optional<ClockStep> StepBetween(UtcTime clock, UtcTime utc) {
  constexpr std::int64_t kQuarter = 900 * kMicrosPerSecond;
  constexpr std::int64_t kWidestZone = std::int64_t{15} * 3600 * kMicrosPerSecond;
  const std::int64_t ahead = (clock - utc).count();
  if (std::abs(ahead) > kWidestZone) return std::nullopt;
  const auto quarters = static_cast<std::int64_t>(std::llround(static_cast<double>(ahead) / kQuarter));
  return ClockStep{std::chrono::minutes(15 * quarters),
                   std::chrono::microseconds(ahead - quarters * kQuarter)};
}

// The zone of the camera's clock beside a UTC that another clock told. A clock that is set by hand is off by
// minutes; one that is off by more shows no zone.
std::optional<std::chrono::minutes> ZoneOf(const ExifRecord& exif, UtcTime utc) {
  if (exif.clock_minus_utc) return exif.clock_minus_utc;
  if (!exif.taken_at) return std::nullopt;
  const std::optional<ClockStep> step = StepBetween(*exif.taken_at, utc);
  if (!step || std::chrono::abs(step->left_over) > std::chrono::minutes(5)) return std::nullopt;
  return step->zone;
}

}  // namespace

CaptureTime ChooseCaptureTime(const ExifRecord& exif, const XmpTags& xmp, std::vector<Remark>& notes) {
  for (const std::string_view name : {"drone-dji:UTCAtExposure", "sensefly:UTCTime"}) {
    if (const auto time = ParseExifTime(xmp.Text(name))) {
      return {InUtc(*time), false, ZoneOf(exif, InUtc(*time))};
    }
  }
  if (exif.taken_at && exif.clock_minus_utc) {
    return {UtcTime(*exif.taken_at - *exif.clock_minus_utc), false, exif.clock_minus_utc};
  }
  if (exif.taken_at && exif.gps_time) {
    const std::optional<ClockStep> step = StepBetween(*exif.taken_at, *exif.gps_time);
    if (step && std::chrono::abs(step->left_over) <= std::chrono::seconds(5)) {
      return {UtcTime(*exif.taken_at - step->zone), false, step->zone};
    }
    notes.push_back(RemarkCode::kClocksDisagree);
    return {exif.gps_time, false, std::nullopt};
  }
  if (exif.gps_time) return {exif.gps_time, false, std::nullopt};
  if (exif.taken_at) return {exif.taken_at, true, std::nullopt};
  for (const std::string_view name : {"exif:DateTimeOriginal", "xmp:CreateDate"}) {
    if (const auto time = ParseExifTime(xmp.Text(name))) {
      return {InUtc(*time), !time->clock_minus_utc, time->clock_minus_utc};
    }
  }
  return {};
}

}  // namespace skyquilt::flight
