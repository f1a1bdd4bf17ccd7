// TakePositionsFromSidecars: the positions that programs write into a file beside a photo in place of the
// photo itself ("DJI_0001.xmp", "DJI_0001.JPG.xmp"; NamesApart calls them alike where folders are lost). What
// a photo says of itself comes before it. Bounded: 1 MiB of a file, those alone that a photo without a
// position has. Any thread. Source: Adobe XMP specification part 3, section 1.3 (sidecar files).
#pragma once

#include <vector>

#include "core/flight/bytes/input_file.h"
#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

// Says in `warnings` of how many nothing was used.
void TakePositionsFromSidecars(const std::vector<InputFile>& sidecars, std::vector<Photo>& photos,
                               std::vector<Remark>& warnings);

}  // namespace skyquilt::flight
