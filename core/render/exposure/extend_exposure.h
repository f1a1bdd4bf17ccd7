// ExtendExposure: tones for photos that were added to a flight whose tones stay: what lens and light do is
// known of the others, and the gain is that at which they agree with what the others show of the same ground.
// Deterministic; one thread. Photos that share no ground with the others get the gain 1.
#pragma once

#include <array>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/render/exposure/exposure.h"
#include "core/render/thumbnail.h"

namespace skyquilt::render {

struct KnownExposure {
  LightModel light;
  std::vector<PhotoLight> photos;
};

// `known`: the light, and that of the first photos of the flight; the others are added. thumbnails[i]
// belongs to photo i.
ExposureModel ExtendExposure(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                             const std::vector<Thumbnail>& thumbnails, const KnownExposure& known);

}  // namespace skyquilt::render
