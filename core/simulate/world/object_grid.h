// ObjectGrid: the standing objects by the cells that they reach into, so that a ray or place is held against
// those near it alone. Frame enu. Immutable; any thread. Rays: "A Fast Voxel Traversal Algorithm for Ray
// Tracing" (Amanatides and Woo 1987).
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include "core/geo/bounds.h"
#include "core/simulate/world/standing_object.h"

namespace skyquilt::simulate {

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
