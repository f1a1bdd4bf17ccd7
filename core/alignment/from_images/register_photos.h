// RegisterPhotos: where photos were taken from what they show alone, without recorded attitude, height or
// position: a view graph verified by two-view geometry and loops of rotations, blocks grown from it and
// adjusted, blocks joined where they share points. Photos that no other shows stay out. Cost grows little
// faster than the photos. The result does not depend on the number of threads. Cancelled through `progress`:
// then what there is so far comes back.
#pragma once

#include "core/alignment/scene/registration.h"
#include "core/base/progress.h"

namespace skyquilt::alignment {

Registration RegisterPhotos(const Registration& given, int threads, Progress& progress);

}  // namespace skyquilt::alignment
