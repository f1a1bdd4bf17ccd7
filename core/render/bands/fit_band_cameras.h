// How a band's camera stands beside the reference's, and through which lens it looks, from sightings.
// Rotation and shift are a capture's own: shutters open some milliseconds apart, in which the aircraft moves
// on and turns. The lens is the camera's in all captures. Pure; any thread. Method: Gauss-Newton with Huber's
// weights and priors.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/camera/intrinsics.h"
#include "core/render/bands/band_cameras.h"
#include "core/render/bands/band_patches.h"

namespace skyquilt::render {

// Through what a band's camera looks.
struct BandLens {
  camera::Intrinsics intrinsics;
  PixelField field;
};

// Sightings of one capture, and what is sought.
struct BandStand {
  std::vector<BandSighting> sightings;
  Eigen::Quaterniond band_from_reference = Eigen::Quaterniond::Identity();
  Eigen::Vector3d shift_in_band_m = Eigen::Vector3d::Zero();  // of a point, after the rotation
};

// Beyond so many pixels a sighting counts as wrong.
inline constexpr double kWrongSightingPx = 2.0;

// False where the sightings do not say it: fewer than six that agree within `scale_px`.
bool FitStand(const BandLens& lens, double scale_px, BandStand& stand);

// Focal length and distortion, over all captures; stays near what it was where sightings say little. The
// field stays.
BandLens FitBandLens(const BandLens& lens, const std::vector<BandStand>& stands);

// The field, over all captures, from what focal length and distortion leave.
PixelField FitBandField(const camera::Intrinsics& intrinsics, const std::vector<BandStand>& stands);

// Pixels between where a sighting is and where it is foretold; a large number where nothing is foretold.
double MissOf(const BandLens& lens, const BandStand& stand, const BandSighting& sighting);

}  // namespace skyquilt::render
