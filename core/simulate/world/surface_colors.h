// What the simulated parcels, and the houses, walls and trees on them, look like from anywhere: sRGB-encoded
// colours 0..255 as a function of place, filtered to a footprint in metres. Pure functions; any thread.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/simulate/world/parcels.h"
#include "core/simulate/world/standing_object.h"

namespace skyquilt::simulate {

struct GroundPoint {
  double east = 0.0;
  double north = 0.0;
  float footprint_m = 0.01f;
  std::uint32_t seed = 0;
};

bool IsWater(const GroundPoint& point, const Parcel& parcel);
Eigen::Vector3f ParcelColor(const GroundPoint& point, const Parcel& parcel, TextureLevel texture);
// Roads, tracks, grass strips over the parcel's colour.
Eigen::Vector3f WithBorders(const GroundPoint& point, const Parcel& parcel, const Eigen::Vector3f& color);
// Trees seen from above, painted with their shade.
Eigen::Vector3f WithTrees(const GroundPoint& point, const Parcel& parcel, const Eigen::Vector3f& color);
Eigen::Vector3f RoofColor(const GroundPoint& point, const Building& building);
// along_m: horizontal position on the wall; up_m: height above its foot.
Eigen::Vector3f WallColor(double along_m, double up_m, const Building& building, float footprint_m);

// Tiles on gables, gravel on flat roofs, windows in the sides of houses; lit by one sun from the south-west
// without cast shadows. `is_side`: the point is on an upright side.
Eigen::Vector3f ObjectColor(const StandingObject& object, const Eigen::Vector3d& point_in_enu, bool is_side,
                            float footprint_m);

}  // namespace skyquilt::simulate
