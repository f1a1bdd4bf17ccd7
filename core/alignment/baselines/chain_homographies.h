// ChainHomographies: the feature-based mosaic of Iz and Unel, their baseline: every photo is matched to the
// one before it and chained to the first by pairwise homographies (eq. 1), then registered once more to the
// mosaic so far, all overlapping photos of it together (eq. 3). No recorded pose is used. A photo that
// matches none of the three before it begins a new component. Errors add up along the chain, as they do in
// such pipelines. Places of a photo are its pixels freed of lens bending, counted from the optical axis. Pure
// apart from threads; the result does not depend on their number.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/alignment/scene/keypoints.h"
#include "core/base/progress.h"
#include "core/camera/intrinsics.h"

namespace skyquilt::alignment {

struct ChainedPhoto {
  int component = -1;  // photos of one component share a mosaic frame; negative: nothing could be read
  Eigen::Matrix3d mosaic_from_photo = Eigen::Matrix3d::Identity();
  int links = 0;           // photos it is registered to
  int inliers = 0;         // matches that agree with where it lies
  double square_px = 0.0;  // their residuals in the mosaic, squared and summed
};

struct ChainedMosaic {
  std::vector<ChainedPhoto> photos;
  int components = 0;
  int pairs_tried = 0;
  int pairs_linked = 0;
};

// By photo, in the order of capture. features: null where it is unreadable; lenses: as recorded.
ChainedMosaic ChainHomographies(const std::vector<const PhotoFeatures*>& features,
                                const std::vector<camera::Intrinsics>& lenses, int threads,
                                Progress& progress);

// Where the chain counts a pixel: without lens bending, from the optical axis.
Eigen::Vector2d PlaceInPhoto(const camera::Intrinsics& lens, const Eigen::Vector2d& pixel_in_image);

}  // namespace skyquilt::alignment
