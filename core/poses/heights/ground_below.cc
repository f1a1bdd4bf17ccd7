#include "core/poses/heights/ground_below.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/base/median.h"
#include "core/geo/geoid.h"
#include "core/poses/heights/flight_heights.h"

namespace skyquilt::poses {
namespace {

geo::LatLon PlaceOf(const PosedPhoto& photo, const geo::LocalFrame& frame) {
  const geo::Wgs84 at = frame.Wgs84FromEnu(photo.cam_from_enu.TargetOriginInSource());
  return {at.lat_deg, at.lon_deg};
}

}  // namespace

void PutGroundByDem(const geo::DemSource& dem, const std::optional<geo::LatLon>& takeoff, DemZero zero,
                    PosedFlight& posed) {
  std::optional<double> zero_m;  // the model's height at z = 0 of the flight's frame
  if (zero == DemZero::kSeaLevel) {
    const geo::Wgs84& origin = posed.frame.origin();
    zero_m = origin.height_ellipsoid_m - geo::GeoidHeightM({origin.lat_deg, origin.lon_deg}).value_or(0.0);
  } else {
    zero_m = dem.GroundHeightM(takeoff.value_or(PlaceOf(posed.photos.front(), posed.frame)));
  }
  if (!zero_m) {
    posed.warnings.push_back(flight::RemarkCode::kElevationModelBesideTakeoff);
    return;
  }
  std::vector<std::optional<double>> ground_z_in_enu_m;  // below each photo; nothing where the model has none
  std::vector<double> known;
  for (const PosedPhoto& photo : posed.photos) {
    const auto height_m = dem.GroundHeightM(PlaceOf(photo, posed.frame));
    ground_z_in_enu_m.push_back(height_m ? std::optional(*height_m - *zero_m) : std::nullopt);
    if (height_m) known.push_back(*height_m - *zero_m);
  }
  if (2 * known.size() < posed.photos.size()) {
    posed.warnings.push_back(flight::RemarkCode::kElevationModelTooSmall);
    return;
  }
  for (std::size_t i = 0; i < posed.photos.size(); ++i) {
    PosedPhoto& photo = posed.photos[i];
    photo.is_beside_dem = !ground_z_in_enu_m[i];
    if (photo.is_beside_dem) continue;
    photo.height_above_ground_m = photo.cam_from_enu.TargetOriginInSource().z() - *ground_z_in_enu_m[i];
  }
  posed.ground_z_in_enu_m = Median(std::move(known));
  posed.dem_zero_m = zero_m;
  if (zero == DemZero::kSeaLevel) return;
  posed.report.height_rule +=
      fmt::format("; the elevation model puts the ground {:+.1f} m from {}", posed.ground_z_in_enu_m,
                  takeoff ? "take-off" : "the first photo, taken for take-off");
}

void TellGapsOfDem(PosedFlight& posed) {
  if (!posed.dem_zero_m) return;
  const auto beside = std::count_if(posed.photos.begin(), posed.photos.end(),
                                    [](const PosedPhoto& photo) { return photo.is_beside_dem; });
  if (beside == 0) return;
  posed.warnings.push_back(
      {flight::RemarkCode::kElevationModelInPart, {{"photos", beside}, {"total", posed.photos.size()}}});
}

void PutGroundBelow(PosedFlight& posed) {
  constexpr double kOnTheGroundM = 1.0;
  std::vector<double> heights, ups;
  std::vector<flight::Photo> photos;
  for (const PosedPhoto& photo : posed.photos) {
    heights.push_back(photo.height_above_ground_m);
    ups.push_back(photo.cam_from_enu.TargetOriginInSource().z());
    photos.push_back(photo.photo);
    const geo::Wgs84 at = posed.frame.Wgs84FromEnu(photo.cam_from_enu.TargetOriginInSource());
    if (!std::isfinite(at.lat_deg + at.lon_deg + heights.back())) return;
    photos.back().position.emplace();
    photos.back().position->position = {at.lat_deg, at.lon_deg};
  }
  const double height_m = Median(std::move(heights));
  if (height_m >= kOnTheGroundM) return;
  const double guessed_m = GuessHeightFromSpacing(photos);
  const double ground_z_m = Median(std::move(ups)) - guessed_m;
  posed.ground_z_in_enu_m = ground_z_m;
  posed.dem_zero_m.reset();  // placed by take-off it would stand above the cameras
  for (PosedPhoto& photo : posed.photos)
    photo.height_above_ground_m = photo.cam_from_enu.TargetOriginInSource().z() - ground_z_m;
  posed.report.height_rule = "height above ground guessed from the spacing of the photos";
  const bool is_untold = posed.report.is_height_guessed.value_or(false);
  posed.report.is_height_guessed = true;
  const auto said = std::find_if(posed.assumptions.begin(), posed.assumptions.end(),
                                 [](const Assumption& one) { return one.height_above_ground_m.has_value(); });
  if (is_untold && said != posed.assumptions.end()) {  // no record tells a height that could be wrong
    said->assumed = {flight::RemarkCode::kHeightBySpacing, {{"height_m", guessed_m}}};
    said->height_above_ground_m = guessed_m;
    return;
  }
  posed.assumptions.push_back({{flight::RemarkCode::kOnTheGround, {{"height_m", height_m}}},
                               {flight::RemarkCode::kHeightBySpacingOnTheGround, {{"height_m", guessed_m}}},
                               guessed_m});
}

void TellLackOfGeoid(const std::optional<double>& geoid_m, const std::vector<flight::Photo>& photos,
                     const flight::FlightLog* log, bool is_zero_of_sea, PosedFlight& posed) {
  if (geoid_m || !posed.report.heights_above_ellipsoid.value_or(false)) return;
  const auto is_of_sea = [](const auto& at) { return at.height_amsl_m && !at.height_ellipsoid_m; };
  const bool is_any_of_sea =
      is_zero_of_sea ||
      std::any_of(photos.begin(), photos.end(),
                  [&](const flight::Photo& photo) { return photo.position && is_of_sea(*photo.position); }) ||
      (log != nullptr && std::any_of(log->gnss.begin(), log->gnss.end(), is_of_sea));
  if (!is_any_of_sea) return;
  posed.report.heights_above_ellipsoid.reset();
  posed.warnings.push_back(flight::RemarkCode::kNoGeoid);
}

}  // namespace skyquilt::poses
