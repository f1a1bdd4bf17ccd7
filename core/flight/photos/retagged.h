// LeaveOutRetagged: files that show one picture, of one moment, and differ in their tags, as programs write
// them that correct positions ("PPK/DJI_0001.JPG", "DJI_0001_geotag.JPG"). Used is the one whose position is
// recorded best: by its stated accuracy, by a fixed solution of RTK, at all. JPEG alone, compared by what
// they hold behind their tags: rigs write equal names in one second too. Any thread; 64 KiB of a file read,
// of those alone whose names and records are alike.
#pragma once

#include <vector>

#include "core/flight/photo.h"

namespace skyquilt::flight {

// Takes all but one of each picture out of `photos`. Those without a file (`path`) stay.
void LeaveOutRetagged(std::vector<Photo>& photos, std::vector<LeftOutPhoto>& left_out);

}  // namespace skyquilt::flight
