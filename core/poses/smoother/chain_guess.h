// The first guess of the smoother, from the best that the inputs offer: recorded attitudes; GNSS tracks;
// without GNSS the chain of photo-to-photo motions scaled by the height; and only last dead reckoning, which
// starts Gauss-Newton kilometres off. Frames and units as in smoother.h. One thread.
#pragma once

#include "core/poses/smoother/chain_problem.h"

namespace skyquilt::poses {

// Leaves `problem` expanded about the guess.
ChainGuess GuessChain(ChainProblem& problem);

}  // namespace skyquilt::poses
