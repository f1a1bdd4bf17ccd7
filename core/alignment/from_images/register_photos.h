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

// Fills the view graph: the pairs of photos that show the same by what they show, each verified by the
// geometry of two views, and all of them by each other: a pair whose turn contradicts what the others say
// round every loop is refused (repeated texture).
void BuildViewGraph(int threads, Progress& progress, Registration& input);

// The same photos through other lenses: what was compared is verified anew.
void VerifyAgain(int threads, Registration& input);

}  // namespace skyquilt::alignment
