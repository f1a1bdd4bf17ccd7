// Photos that an adjusted alignment left out, registered against it one by one by resection (RegisterLost)
// and taken in as if they had always been linked (TakeInLost): also those whose records place them nowhere.
// For a few lost photos of a sound alignment; a flight that is mostly lost is placed anew
// (attempt_by_images.h). The same for any number of threads.
#pragma once

#include <vector>

#include "core/alignment/attempts/attempt_evidence.h"
#include "core/alignment/estimators/absolute_pose.h"
#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/photo_set.h"
#include "core/alignment/scene/priors.h"
#include "core/alignment/scene/tracks.h"
#include "core/alignment/scene/view.h"

namespace skyquilt::alignment {

struct LostInput {
  const std::vector<const PhotoFeatures*>& features;  // of all photos that could be read
  const std::vector<View>& views;                     // adjusted where tied
  const PhotoSet& tied;                               // the alignment
  const std::vector<Track>& tracks;                   // in enu, seen by photos of the alignment
  const std::vector<PhotoRecord>& records;            // say only which photos may show the same
  const Relief& relief;                               // the ground
};

// Their keypoints are matched to those of aligned photos wherever they lie in the picture (no ground window,
// no recorded pose), and the points those see are what the pose is found from; where these are too few, also
// where the aligned photos see the ground under their other keypoints. Links are to aligned photos: matches
// that follow the pose. What is aligned stays as it is.
std::vector<FoundPose> RegisterLost(const LostInput& input, int threads);

// `tracks`: what the attempt's photos see, in enu. How many they are. None where too many are lost for the
// alignment to be sound.
int TakeInLost(const ExtractedFlight& extracted, const std::vector<Track>& tracks, int threads,
               Attempt& attempt);

// Whether there are photos for it.
bool HasLost(const AttemptEvidence& evidence);

}  // namespace skyquilt::alignment
