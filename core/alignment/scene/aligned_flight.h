// AlignedFlight: where every photo of the map was taken and through which lens. Value of align_flight (or of
// AlignByPoseOnly), input of model_ground and of the renderer. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <optional>
#include <vector>

#include "core/camera/footprint.h"
#include "core/camera/intrinsics.h"
#include "core/camera/rolling_shutter.h"
#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"
#include "core/geo/local_frame.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {

enum class Placement { kAligned, kPoseOnly };

struct AlignedPhoto {
  flight::Photo photo;            // as read; its intrinsics are the recorded ones
  camera::Intrinsics intrinsics;  // as refined
  geo::Rigid3 cam_from_enu;
  // How the camera moved while it read its rows; cam_from_enu is of the middle row. Still where that is not
  // known.
  camera::RowMotion readout_motion;
  Placement placement = Placement::kPoseOnly;
  std::vector<flight::Remark> placement_remarks;  // why it is not aligned, or what was corrected
  double error_radius_m =
      0.0;  // 1-sigma horizontal ground error of the image centre, both directions together
  double height_above_ground_m = 0.0;
  double max_look_rad =
      camera::kMaxLookAngleRad;  // off the vertical: the map shows nothing that it sees beyond
  // Off the vertical: how far out other photos see the same ground. Beyond, nothing but this photo's own
  // angles says where things are. Without a limit where no photos are tied to each other.
  double tied_look_rad = 0.5 * std::numbers::pi;
  // The fine detail that it shows, as a share of what others show of the same ground: about 1 for a sharp
  // one.
  std::optional<double> sharpness;
};

// How far off photos lie is known of all; of those that lie by their records, since nothing supports the map
// that the aligned ones lie in; of none, since the records do not say where that map lies either.
enum class ErrorsKnown { kOfAll, kOfPoseOnly, kOfNone };

// Nothing: not known.
inline std::optional<double> KnownErrorM(const AlignedPhoto& photo, ErrorsKnown known) {
  const bool is_aligned = photo.placement == Placement::kAligned;
  if (known == ErrorsKnown::kOfNone || (known == ErrorsKnown::kOfPoseOnly && is_aligned)) return std::nullopt;
  return photo.error_radius_m;
}

struct AlignedFlight {
  geo::LocalFrame frame{geo::Wgs84{}};
  double ground_z_in_enu_m = 0.0;
  std::vector<AlignedPhoto> photos;
  std::vector<flight::LeftOutPhoto> left_out;
  std::vector<flight::Remark> warnings;
  // Points on the ground seen by several photos, in enu; empty without alignment. Input of model_ground.
  std::vector<Eigen::Vector3d> tie_points_in_enu;
};

const char* PlacementName(Placement placement);  // "aligned", "pose_only"

}  // namespace skyquilt::alignment
