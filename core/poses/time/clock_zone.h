// ChooseZone: which time zone a camera's clock was set to, where only the clocks tie its photos to a log. A
// zone fits where the log covers the photos, holes between its parts excluded, and where the track moves
// while they are taken. Of several, in this order: what the photos' own positions, their headings or their
// even spacing on the ground say, whole hours (and the odd zone of the place) before half ones before
// quarters; what is then left is open, and said to be. Pure; deterministic; any thread.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"
#include "core/poses/time/stamped_photos.h"

namespace skyquilt::poses {

struct ZoneChoice {
  int zone_min = 0;                // of the camera's clock ahead of the log's
  double offset_s = 0.0;           // add to a photo's time to get the log's
  std::size_t fitting = 0;         // zones that put the photos onto the moving track
  std::size_t covered = 0;         // photos
  std::vector<int> open_with_min;  // zones that fit as well, and nothing decides
  std::string decided_by;          // in words; empty where no evidence was needed
};

// `times_s`: of the camera's photos, as its clock counts; `as_it_stands_s`: the offset if both clocks were of
// one zone. Nothing where no zone fits.
std::optional<ZoneChoice> ChooseZone(const std::vector<flight::Photo>& photos, const StampedPhotos& camera,
                                     std::span<const double> times_s, double as_it_stands_s,
                                     const flight::FlightLog& log);

// "+05:30".
std::string ZoneInWords(int zone_min);

}  // namespace skyquilt::poses
