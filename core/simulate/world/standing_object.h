// StandingObject: one house, garden wall or tree of the simulated world, a shape whose every height is known.
// ObjectGrid: all of them, found by place. Frame enu (metres, z absolute). Values; any thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/geo/bounds.h"
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

// The standing objects by the cells that they reach into, so that a ray or place is held against those near
// it alone. Rays: "A Fast Voxel Traversal Algorithm for Ray Tracing" (Amanatides and Woo 1987).
class ObjectGrid {
 public:
  struct Top {
    int object = -1;
    double z_m = 0.0;
  };
  struct Hit {
    int object = -1;
    ObjectHit at;
  };

  ObjectGrid() = default;  // of none
  explicit ObjectGrid(std::vector<StandingObject> objects);

  const std::vector<StandingObject>& objects() const { return objects_; }
  std::optional<Top> TopAt(const Eigen::Vector2d& east_north) const;
  // The first one that a ray that goes down meets within max_distance_m.
  std::optional<Hit> CastRay(const Eigen::Vector3d& start, const Eigen::Vector3d& direction,
                             double max_distance_m) const;

 private:
  struct Cell {
    std::vector<int> objects;
    double highest_m = -std::numeric_limits<double>::infinity();
  };
  Eigen::Array2i CellAt(const Eigen::Vector2d& east_north) const;
  const Cell& At(const Eigen::Array2i& cell) const {
    return cells_[static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(size_.x()) +
                  static_cast<std::size_t>(cell.x())];
  }

  std::vector<StandingObject> objects_;
  geo::Bounds2 bounds_;
  double cell_m_ = 0.0;
  Eigen::Array2i size_ = Eigen::Array2i::Zero();
  std::vector<Cell> cells_;
  double highest_m_ = -std::numeric_limits<double>::infinity();
};

}  // namespace skyquilt::simulate
