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

#include "core/alignment/scene/matches.h"
#include "core/alignment/scene/registration.h"

namespace skyquilt::alignment {

inline constexpr int kMinTwoViewMatches = 15;  // fewer are no geometry

// By photo, (x, y, 1) of each of its keypoints, so many at most, freed of distortion.
using KeypointRays = std::vector<std::vector<Eigen::Vector2d>>;
KeypointRays RaysOf(const Registration& input, int most, int threads);

// `compared`: with all matches; samples are seeded by its photos. tolerance_sigmas: of a keypoint's place,
// each photo.
std::optional<PhotoPair> VerifyTwoViews(const Registration& input, const KeypointRays& rays,
                                        const PhotoPair& compared, double tolerance_sigmas = 8.0);

}  // namespace skyquilt::alignment
