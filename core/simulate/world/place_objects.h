// PlaceObjects: where houses, garden walls and trees stand in the simulated world, and how large each is.
// None touches another, and none is buried where the ground is steep. Deterministic in the seed; any thread.
// Errors: kInvalidArgument.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/result.h"
#include "core/simulate/world/standing_object.h"

namespace skyquilt::simulate {

struct ObjectOptions {
  int houses = 0, walls = 0, trees = 0;  // how many; fewer where no room is left for more
  double lowest_house_m = 3.0, highest_house_m = 12.0;
  // East and north: their centres lie within. A simulated flight sets it to the ground that it looks at.
  Eigen::Vector2d area_min = Eigen::Vector2d::Zero(), area_max = Eigen::Vector2d::Zero();

  Result<void> Validate(double flight_height_m) const;
  int Count() const { return houses + walls + trees; }
  bool operator==(const ObjectOptions&) const = default;
};

using TerrainHeight = std::function<double(double east, double north)>;

std::vector<StandingObject> PlaceObjects(const ObjectOptions& options, std::uint32_t seed,
                                         const TerrainHeight& terrain_m);

}  // namespace skyquilt::simulate
