// Features: where a photo can be recognised. Scale-space points (D. Lowe, IJCV 2004) with RootSIFT
// descriptors (Arandjelovic and Zisserman, CVPR 2012) packed into bytes, spread evenly over the photo, plus a
// small grey thumbnail for registration without features. One decode per photo; the pixels are dropped
// afterwards. Pure apart from reading the photo; any number of threads; the same bytes give the same
// features.
#pragma once

#include <cstdint>
#include <vector>

#include "core/alignment/features/describe_point.h"
#include "core/alignment/features/picture_detail.h"
#include "core/base/result.h"
#include "core/flight/photos/photo_source.h"
#include "core/image/decoded_image.h"

namespace skyquilt::alignment {

// Frame `image` of the full-size photo.
struct Keypoint {
  float x_px = 0.0F;
  float y_px = 0.0F;
  float angle_rad = 0.0F;  // from the image's x axis towards its y axis (down)
  float scale_px = 0.0F;   // diameter of the described patch
  float response = 0.0F;
};

// Grey, rows without padding; covers the whole photo.
struct Thumbnail {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> grey;
};

struct PhotoFeatures {
  // Any first n of these are spread over the photo and among the strongest of their place.
  std::vector<Keypoint> keypoints;
  std::vector<Descriptor> descriptors;
  Thumbnail thumbnail;
  double sigma_px = 1.0;  // how well a keypoint is located, in full-size pixels
  PictureDetail detail;
  double decode_s = 0.0;  // wall seconds
  double detect_s = 0.0;
};

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
