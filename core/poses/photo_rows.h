// What lists and camera events say of single photos, written over what the photos say of themselves: a user
// who brings geo.txt, a geolocation CSV or an MRK means it to be better than EXIF. Whether the list is of
// this flight at all, lists/compare_sources.h has found out before. Pure; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"
#include "core/poses/time/time_sync.h"

namespace skyquilt::poses {

struct PhotoRowsUse {
  std::vector<std::string> lines;        // one a list, in words
  std::vector<flight::Remark> warnings;  // lists that name no photo; rows of several; what contradicts photos
};

// Rows that name a photo (lists/named_photos.h) and have no time.
PhotoRowsUse ApplyPhotoRows(const std::vector<flight::FlightLog>& logs, std::vector<flight::Photo>& photos);

// Camera events matched to photos. An event's position is taken where it was surveyed (RTK), where the photo
// has none, or where `log_has_track` is false; its angles where the photo has none. Says how many took one.
int ApplyEvents(const flight::FlightLog& log, const TimeSync& sync, bool log_has_track,
                std::vector<flight::Photo>& photos);

// Photos that know their time on the log's clock, but have no position: the place between the camera events
// before and after, which are no further from each other than some usual intervals, with an error that grows
// with the way between them. Answers how many there are.
int PlaceBetweenEvents(const flight::FlightLog& log, const TimeSync& sync,
                       std::vector<flight::Photo>& photos);

}  // namespace skyquilt::poses
