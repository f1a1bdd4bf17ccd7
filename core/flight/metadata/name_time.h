// Times in file names, for photos whose metadata have none: DJI_20230918115823_0001.JPG,
// IMG_20190102_030405.jpg, 2019-01-02T03-04-05.250Z.png, 2018080501004480Z.jpg, and seconds, milliseconds or
// microseconds since 1970. A time of day is the camera's own, of unknown zone, unless a Z follows or the
// maker is known to write UTC (PXL_); counts since 1970 are UTC. Pure; any thread.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/flight/photo.h"

namespace skyquilt::flight {

struct NameTime {
  UtcTime time;
  bool is_local = true;
};

// Nothing where the name holds no date of 1990 to 2099 with its time of day.
std::optional<NameTime> TimeInName(std::string_view name);

// Gives the photos without a time the one in their names; returns how many. One
// name proves little, so they are believed together or not at all: nearly all of these photos must be named
// by a time, the times must differ, and not count up one by one from midnight as a running number does.
int TakeTimesFromNames(std::vector<Photo>& photos);

}  // namespace skyquilt::flight
