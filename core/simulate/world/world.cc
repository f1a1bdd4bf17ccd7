#include "core/simulate/world/world.h"

#include <algorithm>
#include <cmath>

#include "core/geo/lat_lon.h"
#include "core/simulate/world/random.h"
#include "core/simulate/world/surface_colors.h"

namespace skyquilt::simulate {
namespace {

constexpr double kFlattestRay = 0.0087;  // sine of half a degree: rays nearer to the horizon see the sky

Eigen::Vector3f WithMark(const GroundPoint& p, const WorldOptions& options, const Eigen::Vector3f& color) {
  const double spacing = options.mark_spacing_m;
  const double de = p.east - spacing * std::round(p.east / spacing);
  const double dn = p.north - spacing * std::round(p.north / spacing);
  const double from_center = std::hypot(de, dn);
  const float black = Cover(2.0 * options.mark_radius_m - from_center, p.footprint_m);
  const float white = Cover(options.mark_radius_m - from_center, p.footprint_m);
  const Eigen::Vector3f on_black = color + black * (Eigen::Vector3f::Constant(12.0f) - color);
  return on_black + white * (Eigen::Vector3f::Constant(248.0f) - on_black);
}

}  // namespace

World::World(const WorldOptions& options) : options_(options), parcels_(options.seed, options.texture) {
  for (std::size_t i = 0; i < waves_.size(); ++i) {
    const std::uint32_t hash = HashCell(static_cast<std::int32_t>(i), 7, options.seed);
    const double wavelength_m =
        90.0 * std::pow(1.35, static_cast<double>(i)) * (0.9 + 0.2 * Uniform(hash, 0));
    const double heading = 2.0 * geo::kPi * Uniform(hash, 1);
    const double wave_number = 2.0 * geo::kPi / wavelength_m;
    const double share =
        (1.0 + static_cast<double>(i)) / 21.0;  // longer waves are higher; the shares sum to 1
    waves_[i] = {wave_number * std::sin(heading), wave_number * std::cos(heading),
                 2.0 * geo::kPi * Uniform(hash, 2), share};
    sum_at_origin_ += share * std::sin(waves_[i].phase_rad);
    steepest_ += std::abs(options.relief_m) * share * wave_number;
  }
  highest_m_ = 2.0 * std::abs(options.relief_m) + (options.has_boxes ? kTallestBuildingM : 0.0);
  if (options.objects.Count() > 0) {
    objects_ = ObjectGrid(PlaceObjects(options.objects, options.seed, [this](double east, double north) {
      return TerrainHeightAt(east, north);
    }));
  }
}

double World::TerrainHeightAt(double east, double north) const {
  return options_.relief_m == 0.0 ? 0.0 : TerrainAt(east, north).z();
}

Eigen::Vector3d World::TerrainAt(double east, double north) const {
  Eigen::Vector3d terrain(0.0, 0.0, -sum_at_origin_);
  for (const Wave& wave : waves_) {
    const double phase = wave.east_rad_per_m * east + wave.north_rad_per_m * north + wave.phase_rad;
    const double slope = wave.share * std::cos(phase);
    terrain += Eigen::Vector3d(slope * wave.east_rad_per_m, slope * wave.north_rad_per_m,
                               wave.share * std::sin(phase));
  }
  return options_.relief_m * terrain;
}

double World::BaseOf(const Building& building) const {
  return TerrainHeightAt(building.center_in_enu.x(), building.center_in_enu.y());
}

std::optional<Building> World::BuildingAt(double east, double north) const {
  const Eigen::Vector2d turned = parcels_.ToTurned(east, north);
  std::optional<Building> building = parcels_.BuildingOfCell(FloorToInt(turned.x() / kBuildingCellM),
                                                             FloorToInt(turned.y() / kBuildingCellM));
  if (!building) return std::nullopt;
  const Eigen::Vector2d at = building->ToAxes({east, north});
  if (std::abs(at.x()) > building->half_size_m.x() || std::abs(at.y()) > building->half_size_m.y())
    return std::nullopt;
  return building;
}

std::optional<ObjectGrid::Top> World::ObjectTopAt(double east, double north) const {
  const std::optional<ObjectGrid::Top> top = objects_.TopAt({east, north});
  return top && top->z_m > TerrainHeightAt(east, north) ? top : std::nullopt;
}

int World::ObjectAt(double east, double north) const {
  const std::optional<ObjectGrid::Top> top = ObjectTopAt(east, north);
  return top ? top->object : -1;
}

double World::SurfaceHeightAt(double east, double north) const {
  if (const std::optional<ObjectGrid::Top> top = ObjectTopAt(east, north)) return top->z_m;
  if (options_.has_boxes) {
    if (const std::optional<Building> building = BuildingAt(east, north))
      return BaseOf(*building) + building->height_m;
  }
  return TerrainHeightAt(east, north);
}

bool World::IsWaterAt(double east, double north) const {
  return IsWater({east, north, 0.01f, options_.seed}, parcels_.At(east, north));
}

Eigen::Vector3f World::ColorAt(double east, double north, float footprint_m) const {
  const std::optional<ObjectGrid::Top> top = ObjectTopAt(east, north);
  if (!top) return GroundColorAt(east, north, footprint_m);
  return ObjectColor(objects()[static_cast<std::size_t>(top->object)], {east, north, top->z_m}, false,
                     footprint_m);
}

Eigen::Vector3f World::GroundColorAt(double east, double north, float footprint_m) const {
  const GroundPoint point{east, north, footprint_m, options_.seed};
  const Parcel parcel = parcels_.At(east, north);
  Eigen::Vector3f color = ParcelColor(point, parcel, options_.texture);
  if (options_.texture != TextureLevel::kBare) color = WithBorders(point, parcel, color);
  std::optional<Building> building;
  if (parcel.kind == ParcelKind::kFarmyard) building = BuildingAt(east, north);
  if (building) {
    color = RoofColor(point, *building);
  } else if (options_.texture == TextureLevel::kRich && parcel.kind != ParcelKind::kPond) {
    color = WithTrees(point, parcel, color);
  }
  if (options_.gradient_per_km != 0.0)
    color *= static_cast<float>(std::exp(1e-3 * options_.gradient_per_km * east));
  if (options_.mark_spacing_m > 0.0) color = WithMark(point, options_, color);
  return color.cwiseMax(0.0f).cwiseMin(255.0f);
}

std::optional<RayHit> World::CastRayToTerrain(const Eigen::Vector3d& start, const Eigen::Vector3d& direction,
                                              double max_distance_m, double hint_m) const {
  if (direction.z() > -kFlattestRay) return std::nullopt;
  RayHit hit;
  if (options_.relief_m == 0.0) {
    hit.distance_m = start.z() / -direction.z();
    if (hit.distance_m <= 0.0 || hit.distance_m > max_distance_m) return std::nullopt;
    hit.point_in_enu = start + hit.distance_m * direction;
    hit.point_in_enu.z() = 0.0;
    return hit;
  }
  const double level = direction.head<2>().norm();
  const double above_hills = std::max(0.0, (start.z() - 2.0 * std::abs(options_.relief_m)) / -direction.z());
  // A ray steeper than the steepest slope meets the ground exactly once: Newton. A flatter one is marched
  // down by steps that the slope's bound proves free of ground.
  const bool is_steep = -direction.z() > 1.2 * steepest_ * level;
  const double sink = -direction.z() + steepest_ * level;
  const double newton_start = hint_m > 0.0 ? hint_m : start.z() / -direction.z();
  double t = is_steep ? newton_start : above_hills;
  for (int i = 0; i < 400 && t <= max_distance_m; ++i) {
    const Eigen::Vector3d at = start + t * direction;
    const Eigen::Vector3d terrain = TerrainAt(at.x(), at.y());
    const double gap = at.z() - terrain.z();
    if (std::abs(gap) < 1e-5 || (!is_steep && gap < 1e-4)) {
      hit.distance_m = t;
      hit.point_in_enu = at;
      return hit;
    }
    t += gap / (is_steep ? terrain.head<2>().dot(direction.head<2>()) - direction.z() : sink);
  }
  return std::nullopt;
}

std::optional<RayHit> World::CastRayToBuildings(const Eigen::Vector3d& start,
                                                const Eigen::Vector3d& direction,
                                                double max_distance_m) const {
  // Only the part of the ray below the highest roof can meet one: walk the cells that part lies over.
  const double down = -direction.z();
  if (down < kFlattestRay) return std::nullopt;
  const double lowest_m = -2.0 * std::abs(options_.relief_m);
  const double t_in = std::max(0.0, (start.z() - highest_m_) / down);
  const double t_out = std::min(max_distance_m, (start.z() - lowest_m) / down);
  if (t_out <= t_in) return std::nullopt;
  const Eigen::Vector3d p_in = start + t_in * direction;
  const Eigen::Vector3d p_out = start + t_out * direction;
  const Eigen::Vector2d cell_in = parcels_.ToTurned(p_in.x(), p_in.y()) / kBuildingCellM;
  const Eigen::Vector2d cell_out = parcels_.ToTurned(p_out.x(), p_out.y()) / kBuildingCellM;
  const Eigen::Vector2d low = cell_in.cwiseMin(cell_out).array().floor();
  const Eigen::Vector2d high = cell_in.cwiseMax(cell_out).array().floor();
  std::optional<RayHit> nearest;
  for (auto u = static_cast<std::int32_t>(low.x()); u <= static_cast<std::int32_t>(high.x()); ++u) {
    for (auto v = static_cast<std::int32_t>(low.y()); v <= static_cast<std::int32_t>(high.y()); ++v) {
      const std::optional<Building> building = parcels_.BuildingOfCell(u, v);
      if (!building) continue;
      StandingObject box;  // its sides go below the terrain, so that no gap opens on a slope
      box.outline = *building;
      box.ridge_m = BaseOf(*building) + building->height_m;
      const std::optional<ObjectHit> met = box.CastRay(start, direction);
      if (!met || met->distance_m > max_distance_m) continue;
      if (nearest && nearest->distance_m <= met->distance_m) continue;
      nearest = RayHit{start + met->distance_m * direction, met->distance_m,
                       met->is_side ? SurfaceKind::kWall : SurfaceKind::kRoof, building->hash | 1u, -1};
    }
  }
  return nearest;
}

std::optional<RayHit> World::CastRay(const Eigen::Vector3d& start_in_enu,
                                     const Eigen::Vector3d& direction_in_enu, double max_distance_m,
                                     double hint_m) const {
  std::optional<RayHit> hit = CastRayToTerrain(start_in_enu, direction_in_enu, max_distance_m, hint_m);
  if (!HasUprights() || direction_in_enu.z() > -kFlattestRay) return hit;
  double limit_m = hit ? hit->distance_m : max_distance_m;
  if (const std::optional<ObjectGrid::Hit> met = objects_.CastRay(start_in_enu, direction_in_enu, limit_m)) {
    limit_m = met->at.distance_m;
    const bool is_tree = objects()[static_cast<std::size_t>(met->object)].kind == ObjectKind::kTree;
    const SurfaceKind met_surface = met->at.is_side ? SurfaceKind::kWall : SurfaceKind::kRoof;
    hit =
        RayHit{start_in_enu + limit_m * direction_in_enu, limit_m, is_tree ? SurfaceKind::kTree : met_surface,
               static_cast<std::uint32_t>(met->object) + 1u, met->object};
  }
  if (!options_.has_boxes) return hit;
  if (std::optional<RayHit> box = CastRayToBuildings(start_in_enu, direction_in_enu, limit_m)) return box;
  return hit;
}

Eigen::Vector3f World::ColorOfHit(const RayHit& hit, float footprint_m) const {
  if (hit.object >= 0) {
    return ObjectColor(objects()[static_cast<std::size_t>(hit.object)], hit.point_in_enu,
                       hit.surface == SurfaceKind::kWall, footprint_m);
  }
  if (hit.surface != SurfaceKind::kWall)
    return GroundColorAt(hit.point_in_enu.x(), hit.point_in_enu.y(), footprint_m);
  const Eigen::Vector2d turned = parcels_.ToTurned(hit.point_in_enu.x(), hit.point_in_enu.y());
  const std::optional<Building> building = parcels_.BuildingOfCell(FloorToInt(turned.x() / kBuildingCellM),
                                                                   FloorToInt(turned.y() / kBuildingCellM));
  if (!building) return Eigen::Vector3f::Constant(120.0f);  // a wall's last millimetre beyond its cell
  const Eigen::Vector2d at = building->ToAxes(hit.point_in_enu.head<2>());
  const bool is_long_side =
      building->half_size_m.y() - std::abs(at.y()) < building->half_size_m.x() - std::abs(at.x());
  const double along = is_long_side ? at.x() : at.y() + 50.0;
  return WallColor(along, hit.point_in_enu.z() - BaseOf(*building), *building, footprint_m);
}

}  // namespace skyquilt::simulate
