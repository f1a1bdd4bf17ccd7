// ChooseCaptureTime: the instant of exposure in UTC from the clocks a photo carries, in this order: UTC in
// XMP (drone-dji:UTCAtExposure, sensefly:UTCTime), the camera's clock with its zone, the camera's clock with
// the zone that the GPS time shows (the clock's finer steps are kept where both agree), the GPS time, the
// local clock. Any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/flight/metadata/exif.h"
#include "core/flight/metadata/xmp.h"

namespace skyquilt::flight {

struct CaptureTime {
  std::optional<UtcTime> captured_at;
  bool is_local = false;
};

CaptureTime ChooseCaptureTime(const ExifRecord& exif, const XmpTags& xmp, std::vector<std::string>& notes);

}  // namespace skyquilt::flight
