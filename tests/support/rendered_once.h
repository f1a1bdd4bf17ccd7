// RenderedOnce: the picture of a simulated photo, rendered the first time a process asks for it: stages look
// at each photo several times, and cases fly over the same ground. All that a picture depends on is compared,
// so no case gets another's. Keeps those asked for last, up to 256 MB. Any thread. For tests.
#pragma once

#include "core/simulate/simulate_flight.h"

namespace skyquilt::test {

image::DecodedImage RenderedOnce(const simulate::SimulatedFlight& flight, std::size_t index);

// All of a flight, which it keeps a reference to.
inline simulate::SimulatedPhotoSource PhotosOf(const simulate::SimulatedFlight& flight) {
  return {flight, RenderedOnce};
}

}  // namespace skyquilt::test
