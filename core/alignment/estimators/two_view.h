// VerifyTwoViews: do the matches of two photos fit two cameras that look at one scene, and how were these
// turned to each other? A flat scene, one in relief and a camera that only turned are told apart, because
// they leave different things open. Lenses as given; a focal length that is off by a tenth still verifies.
// Deterministic. Pure; any thread. Method: matches that roughly follow one similarity (each match
// proposes its own); a homography by RANSAC; where that leaves many out, an essential matrix by five points
// (D. Nister, PAMI 2004; in H. Stewenius' form, ISPRS 2006); then all candidate poses refined on Sampson's
// distance.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/alignment/scene/keypoints.h"
#include "core/alignment/scene/matches.h"
#include "core/camera/intrinsics.h"

namespace skyquilt::alignment {

struct TwoViewPhoto {
  const PhotoFeatures* features = nullptr;
  const camera::Intrinsics* lens = nullptr;
  std::vector<Eigen::Vector2d> rays = {};  // (x, y, 1) of each keypoint, freed of distortion
};

inline constexpr int kMinTwoViewMatches = 15;  // fewer are no geometry

// With the rays of so many keypoints at most. Keeps pointers to both.
TwoViewPhoto TwoViewOf(const PhotoFeatures& features, const camera::Intrinsics& lens, int most);

// `compared`: with all matches; samples are seeded by its photos. tolerance_sigmas: of a keypoint's place,
// each photo.
std::optional<PhotoPair> VerifyTwoViews(const TwoViewPhoto& first, const TwoViewPhoto& second,
                                        const PhotoPair& compared, double tolerance_sigmas = 8.0);

}  // namespace skyquilt::alignment
