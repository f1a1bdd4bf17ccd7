// BlockGround: the ground below a block's photos, level where each of them looks: at the height of the points
// that it sees, parallel to the plane through all. For what a photo shows that is no point of the block. A
// value that keeps a reference to its block, which must not move meanwhile. Const methods: any thread.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/alignment/from_images/block.h"

namespace skyquilt::alignment {

class BlockGround {
 public:
  explicit BlockGround(const Block& block);

  // False where the block has too few points to say where the ground is.
  bool is_known() const { return is_known_; }
  // Where a pixel of a placed photo meets it, in the block's world; nothing near or beyond the horizon.
  std::optional<Eigen::Vector3d> Lift(int photo, const Eigen::Vector2d& pixel_in_image) const;
  // Of any camera above the ground below a placed photo, in units of the world.
  double HeightAbove(const geo::Rigid3& cam_from_world, int photo) const;

 private:
  Eigen::Vector3d OnGround(const Eigen::Vector3d& in_world) const {
    return ground_from_world_ * (in_world - middle_);
  }

  const Block* block_;
  std::vector<double> level_;  // by photo
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
  Eigen::Quaterniond ground_from_world_ = Eigen::Quaterniond::Identity();
  bool is_known_ = false;
};

}  // namespace skyquilt::alignment
