// StandingObject: one house, garden wall or tree of the simulated world, a shape whose every height is known.
// Frame enu (metres, z absolute). Values; any thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/simulate/world/parcels.h"

namespace skyquilt::simulate {

enum class ObjectKind : std::uint8_t { kFlatHouse, kGabledHouse, kWall, kTree };

struct Ellipsoid {
  Eigen::Vector3d center_in_enu = Eigen::Vector3d::Zero();
  double half_width_m = 0.0, half_height_m = 0.0;
};

struct ObjectHit {
  double distance_m = 0.0;
  bool is_side = false;  // upright
};

struct StandingObject {
  ObjectKind kind = ObjectKind::kFlatHouse;
  Building outline;       // the rectangle it stands on; of a tree the square round it
  double ground_m = 0.0;  // of the terrain below its centre
  // Of houses and walls, whose sides go down without end, so that no gap opens on a slope: the roof at the
  // centre, its slope along the outline's axis (a wall follows the ground) and its fall to both sides of it.
  double ridge_m = 0.0, rise_per_m = 0.0, fall_per_m = 0.0;
  std::vector<Ellipsoid> crown;  // of a tree: its trunk first; ridge_m is its top

  bool IsHouse() const { return kind == ObjectKind::kFlatHouse || kind == ObjectKind::kGabledHouse; }
  double EaveM() const { return ridge_m - fall_per_m * outline.half_size_m.y(); }
  double HighestM() const { return ridge_m + std::abs(rise_per_m) * outline.half_size_m.x(); }
  double ReachM() const { return outline.half_size_m.norm(); }  // from the centre, horizontally
  // `at` in the outline's axes.
  double RoofHeightAt(const Eigen::Vector2d& at) const {
    return ridge_m + rise_per_m * at.x() - fall_per_m * std::abs(at.y());
  }
  Eigen::Vector3d RoofPointAt(const Eigen::Vector2d& at) const;  // in enu
  std::array<Eigen::Vector3d, 4> Corners() const;                // of the roof, round about

  // The highest point above a place; nothing beside it.
  std::optional<double> TopAt(const Eigen::Vector2d& east_north) const;
  // Where a ray that begins outside enters. `direction` has unit length.
  std::optional<ObjectHit> CastRay(const Eigen::Vector3d& start, const Eigen::Vector3d& direction) const;
};

}  // namespace skyquilt::simulate
