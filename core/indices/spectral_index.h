// SpectralIndex: the vegetation indices that maps are known by name for: formula, the bands that it needs,
// the range of values that is worth colouring, and the ramp for it. Bands are red, green, blue, nir (near
// infrared) and rededge, as reflectances or as 0..1. Constant; any thread. Sources stand beside the formulas.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skyquilt::indices {

struct SpectralIndex {
  std::string_view name;   // "ndvi"
  std::string_view title;  // "NDVI"
  std::string_view expression;
  double least = -1.0, most = 1.0;  // values of the ends of the ramp, unless somebody says otherwise
  std::string_view ramp;
};

std::span<const SpectralIndex> AllIndices();
// In any case of letters; null: there is none.
const SpectralIndex* FindIndex(std::string_view name);
// Those whose bands are all among `bands`, in the order of AllIndices.
std::vector<const SpectralIndex*> IndicesOf(const std::vector<std::string>& bands);

}  // namespace skyquilt::indices
