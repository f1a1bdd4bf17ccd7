// Features: where a photo can be recognised. Scale-space points (D. Lowe, IJCV 2004) with RootSIFT
// descriptors (Arandjelovic and Zisserman, CVPR 2012) packed into bytes, spread evenly over the photo, plus a
// small grey thumbnail for registration without features; of one photo, or of all of a flight in parallel.
// One decode per photo; the pixels are dropped afterwards. Pure apart from reading the photo; any number of
// threads; the same bytes give the same features.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/alignment/scene/keypoints.h"
#include "core/base/progress.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/image/decoded_image.h"
#include "core/poses/posed_flight.h"

namespace skyquilt::alignment {

inline constexpr int kDetectorPixels = 1'500'000;  // of the image given to the detector
inline constexpr int kMaxFoundKeypoints = 2000;    // of a photo

// What a photo is shrunk by when it is decoded for its features.
int DenominatorOf(const flight::Photo& photo);
// Of a photo decoded so. Errors: kCorrupt when it is too small for anything.
Result<PhotoFeatures> FeaturesOf(const flight::Photo& photo, const image::DecodedImage& decoded,
                                 int detector_pixels = kDetectorPixels);
// Decodes it too. Errors: also those of PhotoSource::Decode.
Result<PhotoFeatures> ExtractFeatures(const flight::Photo& photo, const flight::PhotoSource& source);

// By the photo's name, where an earlier decode of the photo found them.
using FoundFeatures = std::map<std::string, PhotoFeatures>;

// Of a flight, by photo. One that cannot be decoded costs its features, not the flight: why stands in their
// place. Takes what was found. Reports progress up to `last_fraction`; stops early, with what there is, when
// it is cancelled.
std::vector<PhotoFeatures> ExtractAll(const poses::PosedFlight& posed, const flight::PhotoSource& source,
                                      FoundFeatures found, int threads, double last_fraction,
                                      Progress& progress);

}  // namespace skyquilt::alignment
