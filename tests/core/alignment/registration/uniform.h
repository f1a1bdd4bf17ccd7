// What tests draw from a Sampler beside whole numbers.
#pragma once

#include "core/alignment/estimators/sampler.h"

namespace skyquilt::alignment {

// In [0, 1).
inline double Uniform(Sampler& sampler) { return static_cast<double>(sampler.Next() >> 11) * 0x1p-53; }

}  // namespace skyquilt::alignment
