// What alignment found, as files that OpenDroneMap takes as a start: cameras.json (its `--cameras`, OpenSfM's
// brown model) and geo.txt (its `--geo`: position, angles and accuracy of every photo). Pure; any thread.
#pragma once

#include <string>

#include "core/alignment/scene/aligned_flight.h"

namespace skyquilt::pipeline {

std::string OdmCamerasJson(const alignment::AlignedFlight& flight);

// Photos whose names hold blanks are left out, as a comment in it says: the format cannot name them.
std::string OdmGeoTxt(const alignment::AlignedFlight& flight);

}  // namespace skyquilt::pipeline
