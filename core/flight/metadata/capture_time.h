// When a photo was taken, by its metadata and, where these say nothing, by its file's name. Any thread.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/flight/metadata/exif.h"
#include "core/flight/metadata/xmp.h"
#include "core/flight/photo.h"

namespace skyquilt::flight {

// Sets the times of `photo`: the exposure in UTC by the clocks it carries, in this order: UTC in XMP
// (drone-dji:UTCAtExposure, sensefly:UTCTime), the camera's clock with its zone, the camera's clock with the
// zone that the GPS time shows (the clock's finer steps are kept where both agree), the GPS time, the local
// clock. A GPS time that names no day counts beside a clock whose zone is written; else the flight tells its
// day. Beside it what a receiver told, used or not, and the zone of the camera's clock, where that is written
// or two clocks show it.
void TakeCaptureTime(const ExifRecord& exif, const XmpTags& xmp, Photo& photo);

// Of photos whose receiver told a time without its day, beside a clock of unknown zone: that clock's zone is
// the one which most of them show to within seconds (from 10 hours behind UTC to 13 ahead, where all but some
// islands lie), and they are in UTC by it. Those whose clock is minutes off it keep the camera's time as it
// is, and so do all where no zone is shown by most: a clock some seconds off would show it to part of them.
void TakeZoneOfFlight(std::vector<Photo>& photos);

// A time in a file's name: DJI_20230918115823_0001.JPG,
// IMG_20190102_030405.jpg, 2019-01-02T03-04-05.250Z.png, 2018080501004480Z.jpg, and seconds, milliseconds or
// microseconds since 1970. A time of day is the camera's own, of unknown zone, unless a Z follows or the
// maker is known to write UTC (PXL_); counts since 1970 are UTC.
struct NameTime {
  UtcTime time;
  bool is_local = true;
};

// Nothing where the name holds no date of 1990 to 2099 with its time of day.
std::optional<NameTime> TimeInName(std::string_view name);

// Gives the photos without a time the one in their names; returns how many. One name proves little, so they
// are believed together or not at all: nearly all of these photos must be named by a time, the times must
// differ, and not count up one by one from midnight as a running number does.
int TakeTimesFromNames(std::vector<Photo>& photos);

}  // namespace skyquilt::flight
