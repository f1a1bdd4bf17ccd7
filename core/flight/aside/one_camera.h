// KeepOneCamera: which of several cameras a map is made of. Cameras differ by lens (as the maker writes it,
// or `_W`, `_Z`, `_T` in names), maker, model, size and view. The map is thermal where thermal pictures are
// more than visible ones by over a ninth. Its camera is the one with most photos of that kind; among those
// that are within a tenth of it the widest. Of the others lie aside:
// thermal pictures where the map's are visible and visible ones where they are thermal, and cameras most of
// whose pictures show what one that stays saw at that moment (2 s, 5 m, or a name that differs in the lens
// alone, looking the same way). What flew elsewhere or at another time stays, so does a rig of like cameras,
// also where their focal lengths differ and no angles say that they look the same way.
// Pictures of single bands are not looked at (core/bands/captures.h). Says what lies aside in left_out, and
// once a camera in warnings. Any thread; n log n, at most 64 pictures looked at for each.
#pragma once

#include "core/flight/flight.h"

namespace skyquilt::flight {

void KeepOneCamera(Flight& flight);

}  // namespace skyquilt::flight
