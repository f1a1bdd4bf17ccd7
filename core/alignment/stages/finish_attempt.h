// FinishAttempt: the last matching pass, on the relief that the first adjustment found, and the last
// adjustment. The same for any number of threads.
#pragma once

#include "core/alignment/stages/attempt.h"

namespace skyquilt::alignment {

Attempt FinishAttempt(Attempt attempt, const AlignOptions& options, Progress& progress);

}  // namespace skyquilt::alignment
