#include "core/alignment/from_images/block_ground.h"

#include <Eigen/Dense>
#include <utility>

#include "core/base/median.h"
#include "core/geo/rigid3.h"

namespace skyquilt::alignment {
namespace {

using Eigen::Vector3d;

constexpr int kMinPointsOfGround = 12;
constexpr double kMinSteepness = 0.2;  // sine of the angle between a ray and level ground

}  // namespace

BlockGround::BlockGround(const Block& block) : block_(&block), level_(block.input().photos.size(), 0.0) {
  std::vector<int> points;
  for (std::size_t t = 0; t < block.scene().tracks.size(); ++t) {
    if (!block.HasPoint(static_cast<int>(t))) continue;
    points.push_back(static_cast<int>(t));
    middle_ += block.Point(static_cast<int>(t));
  }
  if (static_cast<int>(points.size()) < kMinPointsOfGround) return;
  middle_ /= static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const int t : points) spread += (block.Point(t) - middle_) * (block.Point(t) - middle_).transpose();
  Vector3d up = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
  double above = 0.0;
  for (std::size_t i = 0; i < level_.size(); ++i) {
    if (block.Has(static_cast<int>(i)))
      above += up.dot(block.Pose(static_cast<int>(i)).TargetOriginInSource() - middle_);
  }
  if (above < 0.0) up = -up;
  ground_from_world_ = geo::RotationToZ(up);
  std::vector<std::vector<double>> seen(level_.size());
  for (const int t : points) {
    const auto& track = block.scene().tracks[t];
    for (const int s : block.SeenBy(t)) {
      const int photo = track[s].photo;
      seen[photo].push_back(OnGround(block.Point(t)).z());
    }
  }
  for (std::size_t i = 0; i < level_.size(); ++i) {
    if (!seen[i].empty()) level_[i] = Median(std::move(seen[i]));
  }
  is_known_ = true;
}

std::optional<Vector3d> BlockGround::Lift(int photo, const Eigen::Vector2d& pixel_in_image) const {
  const geo::Rigid3& pose = block_->Pose(photo);
  const Vector3d ray_in_world = pose.rotation.conjugate() * block_->Lens(photo).Unproject(pixel_in_image);
  const double falls = -(ground_from_world_ * ray_in_world).z();
  const double height = HeightAbove(pose, photo);
  if (height <= 0.0 || falls < kMinSteepness * ray_in_world.norm()) return std::nullopt;
  return pose.TargetOriginInSource() + height / falls * ray_in_world;
}

double BlockGround::HeightAbove(const geo::Rigid3& cam_from_world, int photo) const {
  return OnGround(cam_from_world.TargetOriginInSource()).z() - level_[photo];
}

}  // namespace skyquilt::alignment
