// MendSunlight: a light sensor's readings that stand alone. Where the readings of one band and camera right
// before and after a photo agree and its own is far off, no cloud was that fast: the sensor was tilted, in a
// shadow of the aircraft or failed, and the photo's values would be off by as much. The value between the two
// counts then; `warnings` says of how many photos. Several readings that are off in a row, or one after the
// other with a true one between them, are left as they are, as are those of photos without a clock. Pure; any
// thread.
#pragma once

#include <vector>

#include "core/bands/captures.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::bands {

void MendSunlight(Captures& captures, std::vector<flight::Remark>& warnings);

}  // namespace skyquilt::bands
