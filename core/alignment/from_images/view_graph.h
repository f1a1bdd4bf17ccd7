// BuildViewGraph: the pairs of photos that show the same by what they show, each verified by the geometry of
// two views, and all of them by each other: a pair whose turn contradicts what the others say round every
// loop is refused (repeated texture). The same for any number of threads.
#pragma once

#include "core/alignment/scene/registration.h"
#include "core/base/progress.h"

namespace skyquilt::alignment {

// Fills the pairs of photos that are to be registered.
void BuildViewGraph(int threads, Progress& progress, Registration& input);

// The same photos through other lenses: what was compared is verified anew.
void VerifyAgain(int threads, Registration& input);

}  // namespace skyquilt::alignment
