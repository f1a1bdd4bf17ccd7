// What alignment found, as files that OpenDroneMap takes as a start: cameras.json (its `--cameras`, OpenSfM's
// brown model) and geo.txt (its `--geo`: position, angles and accuracy of every photo). Pure; any thread.
#pragma once

#include <string>
#include <string_view>

#include "core/alignment/scene/aligned_flight.h"

namespace skyquilt::pipeline {

std::string OdmCamerasJson(const alignment::AlignedFlight& flight);

// Photos whose names hold blanks are left out, as a comment in it says: the format cannot name them.
// `raised_m`: added to all heights, as a comment says too: from the records' zero to that of the survey that
// places the map, from which the list of its points counts. `known`: as of LocateJson.
std::string OdmGeoTxt(const alignment::AlignedFlight& flight, double raised_m = 0.0,
                      alignment::ErrorsKnown known = alignment::ErrorsKnown::kOfAll);

// Whether OdmGeoTxt writes such a text, to the digit: a list of positions that somebody made is none.
bool IsOdmGeoTxt(std::string_view text);

}  // namespace skyquilt::pipeline
