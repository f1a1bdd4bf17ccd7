// Features: where a photo can be recognised. Scale-space points (D. Lowe, IJCV 2004) with RootSIFT
// descriptors (Arandjelovic and Zisserman, CVPR 2012) packed into bytes, spread evenly over the photo, plus a
// small grey thumbnail for registration without features. One decode per photo; the pixels are dropped
// afterwards. Pure apart from reading the photo; any number of threads; the same bytes give the same
// features.
#pragma once

#include <cstdint>
#include <vector>

#include "core/alignment/scene/keypoints.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/image/decoded_image.h"

namespace skyquilt::alignment {

struct FeatureOptions {
  int detector_pixels = 1'500'000;  // of the image given to the detector
  int max_features = 2000;          // 0: the thumbnail alone
  int thumbnail_px = 256;           // longer side
};

// What a photo is shrunk by when it is decoded for its features.
int DenominatorOf(const flight::Photo& photo, const FeatureOptions& options);
// Of a photo decoded so. Errors: kCorrupt when it is too small for anything.
Result<PhotoFeatures> FeaturesOf(const flight::Photo& photo, const image::DecodedImage& decoded,
                                 const FeatureOptions& options);
// Decodes it too. Errors: also those of PhotoSource::Decode.
Result<PhotoFeatures> ExtractFeatures(const flight::Photo& photo, const flight::PhotoSource& source,
                                      const FeatureOptions& options);

}  // namespace skyquilt::alignment
