// EstimateExposure: gains and vignetting from what several photos say of the same ground, for the whole
// flight in one robust least-squares problem on logarithms. Exposures that cameras record count for as much
// as the photos show them: neighbours that differ by them say how much that is, and with it what no overlap
// shows, a drift across the flight, is known; a camera that followed the light shows nothing of them. The
// mean gain of the flight is 1: the ground keeps its natural contrast. Deterministic; one thread; O(photos x
// samples). Source: gain compensation of Brown and Lowe (2007), extended by a vignetting polynomial and a
// robust loss.
#pragma once

#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/ground/ground_surface.h"
#include "core/render/exposure/exposure.h"
#include "core/render/thumbnail.h"

namespace skyquilt::render {

// thumbnails[i] belongs to flight.photos[i].
ExposureModel EstimateExposure(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                               const std::vector<Thumbnail>& thumbnails);

struct KnownExposure {
  LightModel light;
  std::vector<PhotoLight> photos;
};

// For photos that were added to a flight whose tones stay. `known`: the light, and that of the first photos
// of the flight. Of the others the gain is that at which they agree with what the first show of the same
// ground, or others that are evened to these; 1 where they share none.
ExposureModel ExtendExposure(const alignment::AlignedFlight& flight, const ground::GroundSurface& ground,
                             const std::vector<Thumbnail>& thumbnails, const KnownExposure& known);

}  // namespace skyquilt::render
