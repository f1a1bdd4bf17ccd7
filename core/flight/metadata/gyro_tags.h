// TurningFromTags: how a camera turned while it read its rows, by the gyro that it recorded into the photo.
// Camera:IMUAngularVelocity is base64 of 24-byte little-endian records: microseconds of the camera's clock
// (u64), rad/s about x, y, z (3 x f32), a flag (u32); Camera:IMUTimeOffset are the nanoseconds from the first
// record to the first row. Its axes are the body's: on a flight of a Parrot Sequoia these alone of all 48
// ways to name them, mirrored ones too, bring the photos' rows together. Out: samples in time order, seconds
// since the first row began, about the axes of `cam` (x right, y down, z forward). Damaged or impossible
// records give nothing and a note. At most 4096 records. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/flight/metadata/xmp.h"
#include "core/flight/photo.h"

namespace skyquilt::flight {

std::optional<RecordedTurning> TurningFromTags(const XmpTags& xmp, std::vector<Remark>& notes);

}  // namespace skyquilt::flight
