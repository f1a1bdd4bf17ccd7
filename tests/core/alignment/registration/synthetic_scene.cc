#include "tests/core/alignment/registration/synthetic_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/core/alignment/registration/uniform.h"

namespace skyquilt::alignment {
namespace {

constexpr int kSceneKeypoints = 900;

double Normal(Sampler& sampler) {
  return std::sqrt(-2.0 * std::log(1.0 - Uniform(sampler))) *
         std::cos(2.0 * std::numbers::pi * Uniform(sampler));
}

struct GroundPoint {
  Eigen::Vector3d at;
  double direction_rad = 0.0;
  double size_m = 0.3;
  Descriptor descriptor{};
};

Descriptor RandomDescriptor(Sampler& sampler) {
  // As RootSIFT is: a few large entries, many small ones, one length.
  std::array<double, 128> values{};
  double sum = 0.0;
  for (double& value : values) sum += value = std::pow(Uniform(sampler), 3.0);
  Descriptor descriptor{};
  for (std::size_t k = 0; k < descriptor.size(); ++k) {
    descriptor[k] = static_cast<std::uint8_t>(std::min(255.0, 512.0 * std::sqrt(values[k] / sum)));
  }
  return descriptor;
}

Descriptor Disturbed(const Descriptor& descriptor, Sampler& sampler) {
  Descriptor disturbed{};
  for (std::size_t k = 0; k < descriptor.size(); ++k) {
    disturbed[k] = static_cast<std::uint8_t>(std::clamp(descriptor[k] + 6.0 * Normal(sampler), 0.0, 255.0));
  }
  return disturbed;
}

geo::Rigid3 LookDown(const Eigen::Vector3d& center, double yaw_rad, double tilt_rad,
                     double tilt_towards_rad) {
  // Image top towards the heading, x to its right, z down.
  const Eigen::Vector3d forward(std::sin(yaw_rad), std::cos(yaw_rad), 0.0);
  const Eigen::Vector3d right(std::cos(yaw_rad), -std::sin(yaw_rad), 0.0);
  Eigen::Matrix3d cam_from_enu;
  cam_from_enu.row(0) = right.transpose();
  cam_from_enu.row(1) = -forward.transpose();
  cam_from_enu.row(2) = -Eigen::RowVector3d::UnitZ();
  const Eigen::Vector3d axis(std::cos(tilt_towards_rad), std::sin(tilt_towards_rad), 0.0);
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(tilt_rad, axis));
  return geo::Rigid3::FromRotationAndTargetOrigin((tilt * Eigen::Quaterniond(cam_from_enu)).normalized(),
                                                  center);
}

}  // namespace

SyntheticScene MakeScene(const SyntheticOptions& options) {
  SyntheticScene scene;
  scene.lens = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  Sampler sampler(options.seed);
  const int photos = options.columns * options.rows;
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (int p = 0; p < photos; ++p) {
    const int row = p / options.columns;
    const int step = p % options.columns;
    const bool is_back = row % 2 == 1;
    const double share = options.climb_from_share + (1.0 - options.climb_from_share) * p /
                                                        std::max(1.0, static_cast<double>(photos - 1));
    const double east = (is_back ? options.columns - 1 - step : step) * options.step_m * share;
    const Eigen::Vector3d center(east + 0.5 * Normal(sampler),
                                 row * options.step_m * share + 0.5 * Normal(sampler),
                                 options.height_m * share + 0.5 * Normal(sampler));
    double yaw = (is_back ? -0.5 : 0.5) * std::numbers::pi + 0.05 * Normal(sampler);
    if (options.any_yaw) yaw = 2.0 * std::numbers::pi * Uniform(sampler);
    scene.cam_from_enu.push_back(
        LookDown(center, yaw, options.tilt_rad, 2.0 * std::numbers::pi * Uniform(sampler)));
    low = low.cwiseMin(center.head<2>());
    high = high.cwiseMax(center.head<2>());
  }
  const double margin = 1.2 * options.height_m * (0.8 + std::tan(std::min(1.0, options.tilt_rad)));
  low.array() -= margin;
  high.array() += margin;
  const Eigen::Vector2d size = high - low;
  std::vector<GroundPoint> points(static_cast<std::size_t>(options.points_per_m2 * size.x() * size.y()));
  for (GroundPoint& point : points) {
    point.at.head<2>() = low + size.cwiseProduct(Eigen::Vector2d(Uniform(sampler), Uniform(sampler)));
    point.at.z() = options.relief_m * std::sin(point.at.x() / 17.0) * std::cos(point.at.y() / 23.0) +
                   0.1 * options.relief_m * Normal(sampler);
    point.direction_rad = 2.0 * std::numbers::pi * Uniform(sampler);
    point.size_m = 0.1 + 0.2 * Uniform(sampler);
    point.descriptor = RandomDescriptor(sampler);
  }
  for (const geo::Rigid3& pose : scene.cam_from_enu) {
    PhotoFeatures& features = scene.features.emplace_back();
    features.sigma_px = 1.0;
    for (const GroundPoint& point : points) {
      const auto seen = scene.lens.Project(pose * point.at);
      if (!seen || !scene.lens.IsInImage(*seen) || Uniform(sampler) < options.lost_share) continue;
      const Eigen::Vector3d tip =
          point.at + 0.1 * Eigen::Vector3d(std::cos(point.direction_rad), std::sin(point.direction_rad), 0.0);
      const auto beside = scene.lens.Project(pose * tip);
      if (!beside || static_cast<int>(features.keypoints.size()) >= kSceneKeypoints) continue;
      const Eigen::Vector2d way = *beside - *seen;
      Keypoint keypoint;
      keypoint.x_px = static_cast<float>(seen->x() + options.noise_px * Normal(sampler));
      keypoint.y_px = static_cast<float>(seen->y() + options.noise_px * Normal(sampler));
      keypoint.angle_rad = static_cast<float>(std::atan2(way.y(), way.x()) + 0.05 * Normal(sampler));
      keypoint.scale_px =
          static_cast<float>(way.norm() / 0.1 * point.size_m * (1.0 + 0.05 * Normal(sampler)));
      features.keypoints.push_back(keypoint);
      features.descriptors.push_back(Disturbed(point.descriptor, sampler));
    }
  }
  return scene;
}

Registration InputOf(const SyntheticScene& scene, double focal_factor) {
  Registration input;
  BundleLens lens;
  lens.recorded = scene.lens;
  lens.recorded.focal_x_px *= focal_factor;
  lens.recorded.focal_y_px *= focal_factor;
  lens.intrinsics = lens.recorded;
  lens.sigma_focal_share = focal_factor == 1.0 ? 0.01 : 0.1;
  lens.sigma_k = 0.02;
  lens.sigma_p = 0.0003;
  lens.sigma_center_px = 8.0;
  input.lenses.push_back(lens);
  for (const PhotoFeatures& features : scene.features) input.Add(&features, 0, {});
  return input;
}

}  // namespace skyquilt::alignment
