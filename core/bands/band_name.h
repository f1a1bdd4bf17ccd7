// BandNameOf: how makers write the name of a band, brought to one spelling: blue, green, red, rededge, nir,
// panchro, lwir; any other name in lower case, letters and digits alone. Pure; any thread.
#pragma once

#include <string>
#include <string_view>

namespace skyquilt::bands {

inline constexpr const char* kThermalBand = "lwir";

// Empty for a name without letters and digits.
std::string BandNameOf(std::string_view written);

// Lower is better to align by: bands in which soil, plants and roofs differ most, and lenses are sharp.
int AlignRank(std::string_view band_name);

}  // namespace skyquilt::bands
