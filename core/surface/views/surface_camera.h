// SurfaceCamera: one aligned photo as the matching of heights needs it, and which of them to compare over a
// tile: those that see it, nearest to the vertical, and far enough apart that a height shows. Frames enu and
// image. Values; any thread. Angles after Kang, Szeliski and Chai, "Handling occlusions in dense multi-view
// stereo" (2001), and the usual practice of aerial matching (8 to 35 degrees between rays).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/geo/bounds.h"
#include "core/ground/ground_surface.h"

namespace skyquilt::surface {

struct SurfaceCamera {
  std::size_t photo = 0;  // of the flight
  camera::Intrinsics lens;
  geo::Rigid3 cam_from_enu;
  camera::RowMotion motion;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // cam from enu
  Eigen::Vector3d center_in_enu = Eigen::Vector3d::Zero();
  double widest_tangent = 1.0;  // of the look off the vertical
  double height_above_ground_m = 1.0;
  geo::Bounds2 seen_in_enu;  // around what it sees between the lowest and the highest height

  // Whether the point lies in its image and is not looked at from too far aslant.
  bool Sees(const Eigen::Vector3d& point_in_enu) const;
  // How many of its pixels a cell spans, about.
  double CellInPhotoPx(double cell_m) const { return cell_m * lens.MeanFocalPx() / height_above_ground_m; }
};

// The photos whose poses are aligned; heights from low_m below to high_m above the smooth ground are looked
// for.
std::vector<SurfaceCamera> SurfaceCameras(const alignment::AlignedFlight& flight,
                                          const ground::GroundSurface& ground, double low_m, double high_m);

// What is to be seen: a rectangle between two heights.
struct SeenBox {
  geo::Bounds2 in_enu;
  double low_z_m = 0.0, high_z_m = 0.0;
};

struct ChosenViews {
  std::vector<std::size_t> cameras;  // in `cameras`, the one nearest to the vertical first
  double widest_base = 0.0;          // the longest base between two of them over their height
};

// At most `most`; fewer than two where no height can be measured. `among` are indices of `cameras`.
ChosenViews ChooseViews(const std::vector<SurfaceCamera>& cameras, const std::vector<std::size_t>& among,
                        const SeenBox& box, int most);

}  // namespace skyquilt::surface
