// Intrinsics: a pinhole camera with Brown distortion, OpenCV's order and signs. Frame `cam` (x right, y down,
// z forward) to `image` (pixels; the centre of the first pixel is (0,0)). Values; any thread.
// Method: D. C. Brown, Close-Range Camera Calibration (1971). The polynomial folds back on itself far outside
// the image; Project refuses rays beyond the fold instead of returning a pixel that the lens cannot have
// made.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace skyquilt::camera {

struct Intrinsics {
  int width_px = 0;
  int height_px = 0;
  double focal_x_px = 0.0;
  double focal_y_px = 0.0;
  double center_x_px = 0.0;
  double center_y_px = 0.0;
  double k1 = 0.0, k2 = 0.0, k3 = 0.0;  // radial
  double p1 = 0.0, p2 = 0.0;            // tangential

  // A camera without distortion whose axis meets the middle of the image.
  static Intrinsics Centered(int width_px, int height_px, double focal_px);

  bool HasDistortion() const { return k1 != 0.0 || k2 != 0.0 || k3 != 0.0 || p1 != 0.0 || p2 != 0.0; }
  double MeanFocalPx() const { return 0.5 * (focal_x_px + focal_y_px); }
  Eigen::Matrix3d K() const;

  // Normalised coordinates (x/z, y/z) before and after the lens bent the ray.
  Eigen::Vector2d Distort(const Eigen::Vector2d& normalised) const {
    const double x = normalised.x();
    const double y = normalised.y();
    const double r2 = x * x + y * y;
    const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
  }
  Eigen::Vector2d Undistort(const Eigen::Vector2d& distorted) const;

  // The pixel that sees a point of the cam frame; nothing behind the camera or beyond the lens' fold.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point_in_cam) const;
  // Also beyond the fold, where Project has nothing: for what weighs residuals and needs a number for each.
  // The point lies before the camera.
  Eigen::Vector2d ProjectBeyondFold(const Eigen::Vector3d& point_in_cam) const;
  // The ray through a pixel, in cam, with z = 1.
  Eigen::Vector3d Unproject(const Eigen::Vector2d& pixel_in_image) const;

  bool IsInImage(const Eigen::Vector2d& pixel_in_image) const {
    return pixel_in_image.x() >= -0.5 && pixel_in_image.y() >= -0.5 && pixel_in_image.x() <= width_px - 0.5 &&
           pixel_in_image.y() <= height_px - 0.5;
  }
  // The middle of one of across * across equal cells of the image.
  Eigen::Vector2d MiddleOfCell(int column, int row, int across) const {
    return {(column + 0.5) / across * width_px - 0.5, (row + 0.5) / across * height_px - 0.5};
  }
  // Largest r^2 (normalised, undistorted) for which the radial polynomial still grows; infinity without
  // distortion.
  double MaxRadiusSquared() const;

  bool operator==(const Intrinsics&) const = default;
};

// The numbers of a lens, each with the name under which our JSON files have it: `visit(name, value)`; the
// values of a lens that is not const may be set.
template <typename Lens, typename Visit>
void VisitLensFields(Lens& lens, Visit visit) {
  visit("width_px", lens.width_px);
  visit("height_px", lens.height_px);
  visit("focal_x_px", lens.focal_x_px);
  visit("focal_y_px", lens.focal_y_px);
  visit("center_x_px", lens.center_x_px);
  visit("center_y_px", lens.center_y_px);
  visit("k1", lens.k1);
  visit("k2", lens.k2);
  visit("k3", lens.k3);
  visit("p1", lens.p1);
  visit("p2", lens.p2);
}

}  // namespace skyquilt::camera
