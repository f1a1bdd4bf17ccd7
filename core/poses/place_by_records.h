// PlaceByRecords: photos by what they say of themselves: position, camera angles, relative height. What they
// do not say is assumed (straight down, turned along the course) and the covariance says so. What EXIF calls
// the direction of the image turns a photo that has no course or shares no ground with its neighbours: the
// others are turned by what they show. Frame `enu` of the flight. Pure; any thread.
#pragma once

#include <vector>

#include "core/flight/photo.h"
#include "core/geo/local_frame.h"
#include "core/poses/heights/flight_heights.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::poses {

struct PlacedByRecords {
  std::vector<PosedPhoto> photos;
  std::vector<flight::LeftOutPhoto> left_out;
  std::size_t without_angles = 0;
  std::size_t by_direction = 0;         // of these
  std::vector<flight::Photo> unplaced;  // those left out: without a height, or said to be far away
  bool any_without_height = false;
};

// `photos` all have a position; heights as chosen for them. The frame's z = 0 is the ground of those heights.
PlacedByRecords PlaceByRecords(const std::vector<flight::Photo>& photos, const FlightHeights& heights,
                               const geo::LocalFrame& frame);

}  // namespace skyquilt::poses
