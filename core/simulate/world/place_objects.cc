#include "core/simulate/world/place_objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/geo/lat_lon.h"
#include "core/simulate/world/random.h"

namespace skyquilt::simulate {
namespace {

constexpr int kTries = 400;  // without success in a row: there is no room for another
constexpr double kGapM = 1.5;
constexpr double kShortestSideM = 8.0, kLongestSideM = 20.0;
constexpr double kLowestTreeM = 3.0, kHighestTreeM = 10.0;
constexpr double kMinStanding = 0.6;  // of the height of its eaves is above the ground all round
constexpr int kMaxObjects = 2000;     // of a kind
constexpr double kMinHouseM = 2.0, kMaxHouseM = 60.0;
constexpr double kMinAboveHousesM = 10.0;
constexpr std::uint64_t kHouseStream = 701, kWallStream = 702, kTreeStream = 703;

Error BadObjects(std::string message) {
  return Error{ErrorCode::kInvalidArgument, std::move(message), "simulated objects"};
}

StandingObject Anywhere(const ObjectOptions& options, const TerrainHeight& terrain_m, RandomStream& random) {
  StandingObject object;
  const double east = random.Uniform(options.area_min.x(), options.area_max.x());
  const double north = random.Uniform(options.area_min.y(), options.area_max.y());
  const double turn = random.Uniform(0.0, geo::kPi);
  object.outline.center_in_enu = {east, north};
  object.outline.axis_in_enu = {std::cos(turn), std::sin(turn)};
  object.outline.hash = static_cast<std::uint32_t>(random.Next() >> 32);
  object.ground_m = terrain_m(east, north);
  return object;
}

void SetHeight(double height_m, StandingObject& object) {
  object.outline.height_m = height_m;
  object.ridge_m = object.ground_m + height_m;
}

void MakeHouse(const ObjectOptions& options, RandomStream& random, StandingObject& house) {
  const double one = random.Uniform(kShortestSideM, kLongestSideM);
  const double other = random.Uniform(kShortestSideM, kLongestSideM);
  const double steepness = std::tan(random.Uniform(geo::DegToRad(25.0), geo::DegToRad(45.0)));
  house.outline.half_size_m = 0.5 * Eigen::Vector2d(std::max(one, other), std::min(one, other));
  SetHeight(random.Uniform(options.lowest_house_m, options.highest_house_m), house);
  if (random.Uniform() < 0.4) return;
  house.kind = ObjectKind::kGabledHouse;
  house.fall_per_m = std::min(steepness, 0.5 * house.outline.height_m / house.outline.half_size_m.y());
}

void MakeWall(const TerrainHeight& terrain_m, RandomStream& random, StandingObject& wall) {
  wall.kind = ObjectKind::kWall;
  const double half_length_m = random.Uniform(3.0, 9.0);
  wall.outline.half_size_m = {half_length_m, random.Uniform(0.15, 0.3)};
  SetHeight(random.Uniform(1.5, 3.0), wall);
  const Eigen::Vector2d to_end = half_length_m * wall.outline.axis_in_enu;
  const Eigen::Vector2d one = wall.outline.center_in_enu - to_end;
  const Eigen::Vector2d other = wall.outline.center_in_enu + to_end;
  wall.rise_per_m = (terrain_m(other.x(), other.y()) - terrain_m(one.x(), one.y())) / (2.0 * half_length_m);
}

// A broad crown with lumps, or a cone of tiers.
void MakeTree(RandomStream& random, StandingObject& tree) {
  tree.kind = ObjectKind::kTree;
  const double height_m = random.Uniform(kLowestTreeM, kHighestTreeM);
  SetHeight(height_m, tree);
  const auto add = [&](const Eigen::Vector2d& from_axis, double up_m, double half_width_m,
                       double half_height_m) {
    const Eigen::Vector2d at = tree.outline.center_in_enu + from_axis;
    const double z = tree.ground_m + std::min(up_m, height_m - half_height_m);
    tree.crown.push_back({{at.x(), at.y(), z}, half_width_m, half_height_m});
    tree.outline.half_size_m =
        tree.outline.half_size_m.cwiseMax(Eigen::Vector2d::Constant(from_axis.norm() + half_width_m));
  };
  const Eigen::Vector2d axis = Eigen::Vector2d::Zero();
  add(axis, 0.25 * height_m, 0.12 + 0.015 * height_m, 0.3 * height_m);
  if (random.Uniform() < 0.35) {
    const double radius_m = height_m * random.Uniform(0.17, 0.26);
    for (int tier = 0; tier < 5; ++tier) {
      add(axis, (0.2 + 0.17 * tier) * height_m, (1.0 - 0.2 * tier) * radius_m, 0.12 * height_m);
    }
    return;
  }
  const double radius_m = height_m * random.Uniform(0.25, 0.4);
  const double half_height_m = 0.4 * height_m;
  add(axis, height_m, radius_m, half_height_m);
  for (int lump = 0; lump < 8; ++lump) {
    const double round = random.Uniform(0.0, 2.0 * geo::kPi);
    const double up = random.Uniform(-0.3, 0.9);
    const double out_m = 0.75 * radius_m * std::sqrt(1.0 - up * up);
    const double size = random.Uniform(0.25, 0.45);
    add({out_m * std::cos(round), out_m * std::sin(round)}, 0.6 * height_m + 0.75 * half_height_m * up,
        size * radius_m, size * half_height_m);
  }
}

bool AreApart(const Building& one, const Building& other) {
  const Eigen::Vector2d between = other.center_in_enu - one.center_in_enu;
  const auto perpendicular = [](const Eigen::Vector2d& v) { return Eigen::Vector2d(-v.y(), v.x()); };
  const auto reach = [&](const Building& of, const Eigen::Vector2d& along) {
    return of.half_size_m.x() * std::abs(of.axis_in_enu.dot(along)) +
           of.half_size_m.y() * std::abs(perpendicular(of.axis_in_enu).dot(along));
  };
  for (const Eigen::Vector2d& along : {one.axis_in_enu, perpendicular(one.axis_in_enu), other.axis_in_enu,
                                       perpendicular(other.axis_in_enu)}) {
    if (std::abs(between.dot(along)) > reach(one, along) + reach(other, along) + kGapM) return true;
  }
  return false;
}

bool StandsFree(const StandingObject& object, const TerrainHeight& terrain_m) {
  if (object.kind == ObjectKind::kTree) return true;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      const Eigen::Vector3d roof =
          object.RoofPointAt(Eigen::Vector2d(x, y).cwiseProduct(object.outline.half_size_m));
      if (roof.z() - terrain_m(roof.x(), roof.y()) < kMinStanding * (object.EaveM() - object.ground_m))
        return false;
    }
  }
  return true;
}

}  // namespace

Result<void> ObjectOptions::Validate(double flight_height_m) const {
  if (std::min({houses, walls, trees}) < 0 || std::max({houses, walls, trees}) > kMaxObjects) {
    return BadObjects(
        fmt::format("There are to be {} houses, {} walls and {} trees; each number must be from 0 to {}.",
                    houses, walls, trees, kMaxObjects));
  }
  if (!(lowest_house_m >= kMinHouseM && lowest_house_m <= highest_house_m && highest_house_m <= kMaxHouseM)) {
    return BadObjects(fmt::format(
        "Houses are to be {} to {} m high; they can be from {} to {} m high, the lower number first.",
        lowest_house_m, highest_house_m, kMinHouseM, kMaxHouseM));
  }
  const double least_m = std::max(houses > 0 ? highest_house_m : 0.0, trees > 0 ? kHighestTreeM : 0.0);
  if (Count() > 0 && flight_height_m < least_m + kMinAboveHousesM) {
    return BadObjects(fmt::format("A flight over houses or trees of up to {} m must be at least {} m high.",
                                  least_m, least_m + kMinAboveHousesM));
  }
  return {};
}

std::vector<StandingObject> PlaceObjects(const ObjectOptions& options, std::uint32_t seed,
                                         const TerrainHeight& terrain_m) {
  std::vector<StandingObject> placed;
  const auto place = [&](int count, std::uint64_t salt, const auto& make) {
    RandomStream random(seed, salt);
    int failed = 0;
    while (count > 0 && failed < kTries) {
      StandingObject object = Anywhere(options, terrain_m, random);
      make(random, object);
      const bool is_apart = std::all_of(placed.begin(), placed.end(), [&](const StandingObject& other) {
        return AreApart(object.outline, other.outline);
      });
      if (!is_apart || !StandsFree(object, terrain_m)) {
        ++failed;
        continue;
      }
      placed.push_back(std::move(object));
      --count;
      failed = 0;
    }
  };
  place(options.houses, kHouseStream,
        [&](RandomStream& random, StandingObject& house) { MakeHouse(options, random, house); });
  place(options.walls, kWallStream,
        [&](RandomStream& random, StandingObject& wall) { MakeWall(terrain_m, random, wall); });
  place(options.trees, kTreeStream, MakeTree);
  return placed;
}

}  // namespace skyquilt::simulate
