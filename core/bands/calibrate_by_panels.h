// CalibrateByPanels: brings the values of each band to reflectance by pictures of panels whose reflectance is
// known: those that the camera marked (MicaSense), those that a reflectance.csv names, and those at both
// ends of the flight whose panel's code can be read, which leave the flight. Each picture says by which
// factor its band's values are wrong; the median counts for the band's photos by the same camera, of the same
// day where it has pictures of several, and that of all for those of cameras without a picture. Pictures of
// another day than the photos are used where there are none of theirs. A band without a usable picture keeps
// its values. The flight's warnings name pictures that could not be used and count photos of other cameras;
// without a light sensor, photos hours away from the pictures are told too. Decodes the pictures of panels,
// one after the other. Blocking; one thread; never fails.
#pragma once

#include "core/bands/captures.h"
#include "core/flight/flight.h"
#include "core/flight/photos/photo_source.h"

namespace skyquilt::bands {

void CalibrateByPanels(flight::Flight& flight, Captures& captures, const flight::PhotoSource& source);

}  // namespace skyquilt::bands
