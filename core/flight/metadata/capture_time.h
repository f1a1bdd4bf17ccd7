// ChooseCaptureTime: the instant of exposure in UTC from the clocks a photo carries, in this order: UTC in
// XMP (drone-dji:UTCAtExposure, sensefly:UTCTime), the camera's clock with its zone, the camera's clock with
// the zone that the GPS time shows (the clock's finer steps are kept where both agree), the GPS time, the
// local clock. Beside it the zone of the camera's clock, where that is written or two clocks show it. Any
// thread.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "core/flight/metadata/exif.h"
#include "core/flight/metadata/xmp.h"

namespace skyquilt::flight {

struct CaptureTime {
  std::optional<UtcTime> captured_at;
  bool is_local = false;
  std::optional<std::chrono::minutes> clock_minus_utc;  // a time zone's; absent where nothing tells it
};

CaptureTime ChooseCaptureTime(const ExifRecord& exif, const XmpTags& xmp, std::vector<Remark>& notes);

}  // namespace skyquilt::flight
