// ViewScore: how well a photo shows a point of the ground, in metres; lower is better. Nadir distance first
// (things lean less), then how well the photo's place is known; towards its own border a photo gives way.
// Values; any thread.
#pragma once

#include <algorithm>

#include "core/alignment/aligned_flight.h"

namespace skyquilt::render {

struct ViewScore {
  float width_px = 0.0f, height_px = 0.0f;  // of the image
  float taper_px = 1.0f;
  float border_penalty_m = 0.0f;
  float constant_m = 0.0f;

  static ViewScore Of(const alignment::AlignedPhoto& photo);

  // Distance to the nearest edge of the image; negative outside.
  float Margin(float x, float y) const {
    return std::min(std::min(x + 0.5f, width_px - 0.5f - x), std::min(y + 0.5f, height_px - 0.5f - y));
  }
  float Score(float nadir_distance_m, float margin_px) const {
    const float lack = std::max(0.0f, 1.0f - margin_px / taper_px);
    return nadir_distance_m + constant_m + border_penalty_m * lack * lack;
  }
};

}  // namespace skyquilt::render
