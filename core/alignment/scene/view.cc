#include "core/alignment/scene/view.h"

#include <cmath>

#include "core/base/bilinear_grid.h"
#include "core/base/median.h"
#include "core/geo/bounds.h"

namespace skyquilt::alignment {
namespace {

constexpr int kMaxCells = 1 << 20;
constexpr int kFewPoints = 50;
constexpr double kFarthestM = 1e6;  // points beyond, or not numbers, are of no use

constexpr double kFlattestRay = 0.2;  // sine of the least angle below the horizon that is still of use

bool MeetAlong(const Eigen::Vector3d& center, const Eigen::Vector3d& ray, const Relief& relief,
               Eigen::Vector3d* point) {
  if (ray.z() > -kFlattestRay * ray.norm()) return false;
  double z = relief.MeanHeight();
  for (int i = 0; i < (relief.IsFlat() ? 1 : 4); ++i) {
    const double reach = (z - center.z()) / ray.z();
    if (reach <= 0.0) return false;
    *point = center + reach * ray;
    z = relief.HeightAt(point->head<2>());
  }
  return true;
}

}  // namespace

Relief Relief::FromPoints(const std::vector<Eigen::Vector3d>& all_points_in_enu, double cell_m,
                          double plane_z_in_enu_m) {
  std::vector<Eigen::Vector3d> points_in_enu;
  for (const Eigen::Vector3d& point : all_points_in_enu) {
    if (point.cwiseAbs().maxCoeff() < kFarthestM) points_in_enu.push_back(point);
  }
  if (points_in_enu.size() < kFewPoints) return Relief(plane_z_in_enu_m);
  std::vector<double> heights;
  geo::Bounds2 bounds;
  for (const Eigen::Vector3d& point : points_in_enu) {
    heights.push_back(point.z());
    bounds.Include(Eigen::Vector2d(point.head<2>()));
  }
  Relief relief(Median(heights));
  cell_m = std::max({cell_m, std::sqrt(bounds.Width() * bounds.Height() / kMaxCells),
                     3.0 * std::max(bounds.Width(), bounds.Height()) / kMaxCells});
  relief.cell_m_ = cell_m;
  relief.south_west_ = bounds.min;
  relief.columns_ = static_cast<int>(bounds.Width() / cell_m) + 2;
  relief.rows_ = static_cast<int>(bounds.Height() / cell_m) + 2;
  const std::size_t cells = static_cast<std::size_t>(relief.columns_) * relief.rows_;
  std::vector<std::vector<double>> inside(cells);
  for (const Eigen::Vector3d& point : points_in_enu) {
    const Eigen::Vector2d at = (point.head<2>() - bounds.min) / cell_m;
    const std::size_t cell = std::lround(at.y()) * relief.columns_ + std::lround(at.x());
    inside[cell].push_back(point.z());
  }
  relief.heights_m_.assign(cells, static_cast<float>(relief.mean_z_m_));
  std::vector<bool> known(cells, false);
  for (std::size_t i = 0; i < cells; ++i) {
    if (inside[i].empty()) continue;
    relief.heights_m_[i] = static_cast<float>(Median(inside[i]));
    known[i] = true;
  }
  // Spread what is known into the empty cells, then let everything settle a little.
  for (int sweep = 0; sweep < 60; ++sweep) {
    for (int row = 0; row < relief.rows_; ++row) {
      for (int column = 0; column < relief.columns_; ++column) {
        const std::size_t at = static_cast<std::size_t>(row) * relief.columns_ + column;
        if (known[at]) continue;
        double sum = 0.0;
        int count = 0;
        const auto add = [&](int r, int c) {
          if (r < 0 || c < 0 || r >= relief.rows_ || c >= relief.columns_) return;
          sum += relief.heights_m_[static_cast<std::size_t>(r) * relief.columns_ + c];
          ++count;
        };
        add(row - 1, column);
        add(row + 1, column);
        add(row, column - 1);
        add(row, column + 1);
        relief.heights_m_[at] = static_cast<float>(sum / count);
      }
    }
  }
  return relief;
}

double Relief::HeightAt(const Eigen::Vector2d& east_north) const {
  if (IsFlat()) return mean_z_m_;
  const Eigen::Vector2d node = (east_north - south_west_) / cell_m_;
  return BilinearAt(heights_m_, columns_, rows_, node.x(), node.y());
}

Eigen::Vector2d AxisOnGround(const Eigen::Quaterniond& enu_from_cam, const Eigen::Vector3d& center,
                             double ground_z_m) {
  const Eigen::Vector3d axis = enu_from_cam * Eigen::Vector3d::UnitZ();
  if (axis.z() > -0.2) return center.head<2>();
  return (center + (ground_z_m - center.z()) / axis.z() * axis).head<2>();
}

bool MeetGround(const View& view, const Relief& relief, const Eigen::Vector2d& pixel_in_image,
                Eigen::Vector3d* point_in_enu) {
  const geo::Rigid3 cam_from_enu = view.CamFromEnuAt(pixel_in_image);
  const Eigen::Vector3d ray = cam_from_enu.rotation.conjugate() * view.intrinsics.Unproject(pixel_in_image);
  return MeetAlong(cam_from_enu.TargetOriginInSource(), ray, relief, point_in_enu);
}

std::vector<GroundKeypoint> ProjectToGround(const PhotoFeatures& features, const View& view,
                                            const Relief& relief) {
  std::vector<GroundKeypoint> projected(features.keypoints.size());
  const bool moves = !view.readout_motion.IsStill();
  Eigen::Vector3d center = view.CenterInEnu();
  Eigen::Quaterniond enu_from_cam = view.cam_from_enu.rotation.conjugate();
  for (std::size_t i = 0; i < projected.size(); ++i) {
    const Keypoint& keypoint = features.keypoints[i];
    if (moves) {
      const geo::Rigid3 there = view.CamFromEnuAt({keypoint.x_px, keypoint.y_px});
      center = there.TargetOriginInSource();
      enu_from_cam = there.rotation.conjugate();
    }
    const Eigen::Vector3d ray_in_cam = view.intrinsics.Unproject({keypoint.x_px, keypoint.y_px});
    Eigen::Vector3d point;
    if (!MeetAlong(center, enu_from_cam * ray_in_cam, relief, &point)) continue;
    // The same step in the image, as a ray beside the first; the lens bends both alike.
    const double reach = keypoint.scale_px / view.intrinsics.focal_x_px;
    const Eigen::Vector3d beside_in_cam =
        ray_in_cam +
        Eigen::Vector3d(reach * std::cos(keypoint.angle_rad), reach * std::sin(keypoint.angle_rad), 0.0);
    const Eigen::Vector3d beside_ray = enu_from_cam * beside_in_cam;
    if (beside_ray.z() > -0.05) continue;
    const Eigen::Vector3d beside = center + ((point.z() - center.z()) / beside_ray.z()) * beside_ray;
    const Eigen::Vector2d step = (beside - point).head<2>();
    projected[i].place = {point.x(), point.y()};
    projected[i].angle_rad = static_cast<float>(std::atan2(step.y(), step.x()));
    projected[i].log2_scale = static_cast<float>(std::log2(std::max(1e-6, step.norm())));
    projected[i].is_on_ground = true;
  }
  return projected;
}

}  // namespace skyquilt::alignment
