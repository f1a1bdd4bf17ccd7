// Photos that an adjusted alignment left out, registered against it one by one by resection (RegisterLost)
// and taken in as if they had always been linked (TakeInLost): also those whose records place them nowhere.
// For a few lost photos of a sound alignment; a flight that is mostly lost is placed anew
// (attempt_by_images.h). The same for any number of threads.
#pragma once

#include <vector>

#include "core/alignment/attempts/attempt_evidence.h"
#include "core/alignment/estimators/absolute_pose.h"
#include "core/alignment/scene/photo_set.h"
#include "core/alignment/scene/tracks.h"

namespace skyquilt::alignment {

// Their keypoints are matched to those of aligned photos wherever they lie in the picture (no ground window,
// no recorded pose), and the points those see are what the pose is found from; where these are too few, also
// where the aligned photos see the ground under their other keypoints. Links are to aligned photos: matches
// that follow the pose. What is aligned stays as it is. `tied`: the alignment, whose views are adjusted.
// `tracks`: in enu, seen by its photos.
std::vector<FoundPose> RegisterLost(const ExtractedFlight& extracted, const Attempt& attempt,
                                    const PhotoSet& tied, const std::vector<Track>& tracks, int threads);

// `tracks`: what the attempt's photos see, in enu. How many they are. None where too many are lost for the
// alignment to be sound.
int TakeInLost(const ExtractedFlight& extracted, const std::vector<Track>& tracks, int threads,
               Attempt& attempt);

// Whether there are photos for it.
bool HasLost(const AttemptEvidence& evidence);

}  // namespace skyquilt::alignment
