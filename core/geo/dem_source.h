// DemSource: the port through which the stages ask an elevation model.
#pragma once

#include <optional>

#include "core/geo/lat_lon.h"

namespace skyquilt::geo {

// Heights of the ground, above whatever zero the model has: only differences and, where the model counts from
// sea level, absolute heights make sense.
class DemSource {
 public:
  virtual ~DemSource() = default;
  // Nothing outside the model or where it has a hole. One thread at a time.
  virtual std::optional<double> GroundHeightM(const LatLon& position) const = 0;
};

}  // namespace skyquilt::geo
