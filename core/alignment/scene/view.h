// View: the pose and lens of a photo while its alignment is being found, and what its keypoints become on the
// ground under it, whose coarse shape is a Relief. Values; any thread.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <complex>
#include <vector>

#include "core/alignment/scene/keypoints.h"
#include "core/camera/intrinsics.h"
#include "core/camera/rolling_shutter.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {

// The ground as the alignment itself knows it, so that a rematch searches in the right place. A plane until
// points are known. (The map's own surface is core/ground's.)
class Relief {
 public:
  explicit Relief(double plane_z_in_enu_m) : mean_z_m_(plane_z_in_enu_m) {}
  // Medians of the points' heights in cells of cell_m, empty cells filled from their neighbours.
  static Relief FromPoints(const std::vector<Eigen::Vector3d>& all_points_in_enu, double cell_m,
                           double plane_z_in_enu_m);

  bool IsFlat() const { return heights_m_.empty(); }
  double MeanHeight() const { return mean_z_m_; }
  double HeightAt(const Eigen::Vector2d& east_north) const;

 private:
  double mean_z_m_ = 0.0;
  Eigen::Vector2d south_west_ = Eigen::Vector2d::Zero();
  double cell_m_ = 1.0;
  int columns_ = 0, rows_ = 0;
  std::vector<float> heights_m_;
};

struct View {
  camera::Intrinsics intrinsics;
  geo::Rigid3 cam_from_enu;
  double height_above_ground_m = 50.0;
  camera::RowMotion readout_motion;  // as AlignedPhoto has it

  // While the row of that pixel was read.
  geo::Rigid3 CamFromEnuAt(const Eigen::Vector2d& pixel_in_image) const {
    return camera::PoseAtRow(cam_from_enu, readout_motion, pixel_in_image.y(), intrinsics.height_px);
  }
  Eigen::Vector3d CenterInEnu() const { return cam_from_enu.TargetOriginInSource(); }
  double GsdM() const { return height_above_ground_m / intrinsics.MeanFocalPx(); }
  // Ground covered across the longer side, straight down.
  double WidthM() const { return GsdM() * std::max(intrinsics.width_px, intrinsics.height_px); }
};

// Where the cameras are, of photos of any kind that have a pose.
template <typename Photo>
std::vector<Eigen::Vector2d> EastNorthOf(const std::vector<Photo>& photos) {
  std::vector<Eigen::Vector2d> places;
  for (const Photo& photo : photos)
    places.push_back(photo.cam_from_enu.TargetOriginInSource().template head<2>());
  return places;
}

// A keypoint projected to the ground; a complex number is E + iN in enu metres.
struct GroundKeypoint {
  std::complex<double> place;
  float angle_rad = 0.0F;     // of its direction, from east towards north
  float log2_scale = 0.0F;    // of its size in metres
  bool is_on_ground = false;  // false where the view runs towards the horizon
};

// By photo; none of one that could not be read.
using GroundKeypoints = std::vector<std::vector<GroundKeypoint>>;

std::vector<GroundKeypoint> ProjectToGround(const PhotoFeatures& features, const View& view,
                                            const Relief& relief);

// Where the optical axis meets level ground; straight below the camera when it hardly looks down.
Eigen::Vector2d AxisOnGround(const Eigen::Quaterniond& enu_from_cam, const Eigen::Vector3d& center,
                             double ground_z_m);

// Where the ray through a pixel meets the relief (E, N, z); false when it does not come down within reach.
bool MeetGround(const View& view, const Relief& relief, const Eigen::Vector2d& pixel_in_image,
                Eigen::Vector3d* point_in_enu);

}  // namespace skyquilt::alignment
