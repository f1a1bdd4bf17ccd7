// BuildViewGraph: the pairs of photos that show the same by what they show, each verified by the geometry of
// two views, and all of them by each other: a pair whose turn contradicts what the others say round every
// loop is refused (repeated texture). The same for any number of threads.
#pragma once

#include <vector>

#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/registration.h"
#include "core/base/progress.h"

namespace skyquilt::alignment {

struct ViewGraph {
  std::vector<PhotoPair> compared;  // with enough matches for a geometry
  std::vector<PhotoPair> pairs;     // sorted, each agreeing with the others
  RegistrationReport report;
};

ViewGraph BuildViewGraph(const Registration& input, int threads, Progress& progress);

// The same photos through other lenses: what was compared is verified anew.
void VerifyAgain(const Registration& input, int threads, ViewGraph& graph);

}  // namespace skyquilt::alignment
