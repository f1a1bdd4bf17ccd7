// World: an endless simulated landscape, a pure deterministic function of (seed, E, N) in the flight's enu
// frame (metres; flat ground is z = 0). Immutable; any thread. Colours are sRGB-encoded values 0..255 (what a
// JPEG holds), not linear light. Every colour is asked for with a footprint (the filter's width in metres,
// about one pixel on the ground): texture finer than that is faded out, so that far views do not alias and
// photo and truth agree at any scale.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/simulate/world/parcels.h"
#include "core/simulate/world/place_objects.h"
#include "core/simulate/world/standing_object.h"

namespace skyquilt::simulate {

struct WorldOptions {
  std::uint32_t seed = 1;
  TextureLevel texture = TextureLevel::kRich;
  double relief_m = 0.0;   // amplitude of smooth hills (heights within about +-relief); 0 = flat at z = 0
  bool has_boxes = false;  // buildings stand up; otherwise their roofs are painted on the ground
  // Survey marks: a white disc on a black one at every multiple of this distance in E and N; 0 = none.
  double mark_spacing_m = 0.0;
  // How much brighter the ground becomes to the east, as a logarithm.
  double gradient_per_km = 0.0;
  double mark_radius_m = 0.25;  // of the white disc; the black one is twice as wide
  ObjectOptions objects;        // houses, walls and trees that stand on it

  bool operator==(const WorldOptions&) const = default;
};

enum class SurfaceKind : std::uint8_t { kGround, kRoof, kWall, kTree };

struct RayHit {
  Eigen::Vector3d point_in_enu = Eigen::Vector3d::Zero();
  double distance_m = 0.0;
  SurfaceKind surface = SurfaceKind::kGround;
  std::uint32_t building = 0;  // tells one building or tree from the next; 0 = none
  int object = -1;             // of World::objects(); -1 = none
};

class World {
 public:
  explicit World(const WorldOptions& options);

  const WorldOptions& options() const { return options_; }
  const std::vector<StandingObject>& objects() const { return objects_.objects(); }
  bool HasUprights() const { return options_.has_boxes || !objects().empty(); }
  // The terrain without buildings; 0 at the origin of enu.
  double TerrainHeightAt(double east, double north) const;
  // What one sees from straight above: terrain, roof or crown.
  double SurfaceHeightAt(double east, double north) const;
  // Which of objects() one sees there; -1 = none.
  int ObjectAt(double east, double north) const;
  // Whether the ground there is a pond.
  bool IsWaterAt(double east, double north) const;
  // Colour (red, green, blue) of that surface.
  Eigen::Vector3f ColorAt(double east, double north, float footprint_m) const;

  // The first surface that a ray meets; nothing for rays that stay above the horizon or run beyond
  // max_distance_m. `direction_in_enu` has unit length. Exact on flat ground; within 0.1 mm of height on
  // relief, where the search begins at hint_m (the distance of a neighbouring ray's hit) if that is positive.
  std::optional<RayHit> CastRay(const Eigen::Vector3d& start_in_enu, const Eigen::Vector3d& direction_in_enu,
                                double max_distance_m, double hint_m = 0.0) const;
  Eigen::Vector3f ColorOfHit(const RayHit& hit, float footprint_m) const;

 private:
  struct Wave {
    double east_rad_per_m, north_rad_per_m, phase_rad, share;
  };
  // Slopes to the east and north, and the height.
  Eigen::Vector3d TerrainAt(double east, double north) const;
  std::optional<RayHit> CastRayToTerrain(const Eigen::Vector3d& start, const Eigen::Vector3d& direction,
                                         double max_distance_m, double hint_m) const;
  std::optional<RayHit> CastRayToBuildings(const Eigen::Vector3d& start, const Eigen::Vector3d& direction,
                                           double max_distance_m) const;
  // The ground, and the boxes that stand or are painted on it.
  Eigen::Vector3f GroundColorAt(double east, double north, float footprint_m) const;
  std::optional<Building> BuildingAt(double east, double north) const;
  std::optional<ObjectGrid::Top> ObjectTopAt(double east, double north) const;  // not one below the terrain
  double BaseOf(const Building& building) const;

  WorldOptions options_;
  Parcels parcels_;
  std::array<Wave, 6> waves_;
  double sum_at_origin_ = 0.0;  // of the waves: subtracted, so that the origin lies at 0
  double steepest_ = 0.0;       // bound of the terrain's slope
  double highest_m_ = 0.0;      // bound of the terrain and its boxes
  ObjectGrid objects_;
};

}  // namespace skyquilt::simulate
