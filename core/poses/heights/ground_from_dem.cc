#include "core/poses/heights/ground_from_dem.h"

#include "core/base/median.h"
#include "core/geo/geoid.h"

namespace skyquilt::poses {

std::variant<DemGround, flight::RemarkCode> GroundFromDem(const geo::DemSource& dem, const PosedFlight& posed,
                                                          const std::optional<geo::LatLon>& takeoff,
                                                          DemZero zero) {
  const auto below = [&](const PosedPhoto& photo) {
    const geo::Wgs84 at = posed.frame.Wgs84FromEnu(photo.cam_from_enu.TargetOriginInSource());
    return geo::LatLon{at.lat_deg, at.lon_deg};
  };
  std::optional<double> zero_m;
  if (zero == DemZero::kSeaLevel) {
    const geo::Wgs84& origin = posed.frame.origin();
    zero_m = origin.height_ellipsoid_m - geo::GeoidHeightM({origin.lat_deg, origin.lon_deg}).value_or(0.0);
  } else {
    zero_m = dem.GroundHeightM(takeoff.value_or(below(posed.photos.front())));
  }
  if (!zero_m) return flight::RemarkCode::kElevationModelBesideTakeoff;
  DemGround ground;
  ground.zero_m = *zero_m;
  std::vector<double> grounds;
  for (const PosedPhoto& photo : posed.photos) {
    const auto height_m = dem.GroundHeightM(below(photo));
    ground.ground_z_in_enu_m.push_back(height_m ? std::optional(*height_m - ground.zero_m) : std::nullopt);
    if (height_m) grounds.push_back(*height_m - ground.zero_m);
  }
  if (2 * grounds.size() < posed.photos.size()) return flight::RemarkCode::kElevationModelTooSmall;
  ground.median_ground_z_in_enu_m = Median(std::move(grounds));
  return ground;
}

}  // namespace skyquilt::poses
