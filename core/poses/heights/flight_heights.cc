#include "core/poses/heights/flight_heights.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "core/base/median.h"
#include "core/geo/geodesic.h"
#include "core/geo/geoid.h"
#include "core/geo/local_frame.h"

namespace skyquilt::poses {
namespace {

using flight::Photo;
using flight::RecordedPosition;

std::optional<double> AboveGround(const RecordedPosition& position) {
  // A relative height of a few decimetres is a drone on the ground or a field that is never filled.
  if (position.height_above_takeoff_m && *position.height_above_takeoff_m > 1.0) {
    return position.height_above_takeoff_m;
  }
  if (position.height_above_ground_m && *position.height_above_ground_m > 1.0)
    return position.height_above_ground_m;
  return std::nullopt;
}

// At the first, or in the middle of most where the first is a fix from elsewhere: projected to the level of
// another part of the Earth, steps are shorter than they are.
std::optional<geo::LocalFrame> FrameAboutMost(const std::vector<Photo>& photos) {
  constexpr double kElsewhereM = 50'000.0;
  std::vector<geo::LatLon> positions;
  for (const Photo& photo : photos) {
    if (photo.position) positions.push_back(photo.position->position);
  }
  const std::optional<geo::LatLon> middle = MedianPosition(positions);
  if (!middle) return std::nullopt;
  const bool is_elsewhere = geo::MetresApart(positions.front(), *middle) > kElsewhereM;
  const geo::LatLon& origin = is_elsewhere ? *middle : positions.front();
  return geo::LocalFrame({origin.lat_deg, origin.lon_deg, 0.0});
}

// The height at which photos spaced as these are would overlap by the usual three quarters along the line.
std::optional<double> HeightFromSpacing(const std::vector<Photo>& photos) {
  const std::optional<geo::LocalFrame> frame = FrameAboutMost(photos);
  if (!frame) return std::nullopt;
  std::vector<double> spacings;
  std::optional<Eigen::Vector3d> before;
  for (const Photo& photo : photos) {
    if (!photo.position) continue;
    const geo::Wgs84 here{photo.position->position.lat_deg, photo.position->position.lon_deg, 0.0};
    const Eigen::Vector3d at = frame->EnuFromWgs84(here);
    if (before) {
      const double step_m = (at - *before).head<2>().norm();
      if (step_m > 0.5) spacings.push_back(step_m);
    }
    before = at;
  }
  const std::optional<double> spacing_m = MedianIfAny(std::move(spacings));
  if (!spacing_m) return std::nullopt;
  const camera::Intrinsics& lens = photos.front().intrinsics;
  constexpr double kUsualForwardStep = 0.25;
  const double short_side_px = std::min(lens.width_px, lens.height_px);
  return *spacing_m / kUsualForwardStep * lens.MeanFocalPx() / short_side_px;
}

// Absolute heights over the place of take-off, whose height somebody gives. False: none lies above it.
bool ByGivenTakeoff(const std::vector<Photo>& photos, double takeoff_ellipsoid_m, FlightHeights& heights) {
  constexpr double kLowestFlightM = 5.0;
  std::vector<std::optional<double>> above_m(photos.size());
  std::vector<double> known;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!photos[i].position) continue;
    if (const auto ellipsoid_m = EllipsoidHeightM(*photos[i].position)) {
      above_m[i] = *ellipsoid_m - takeoff_ellipsoid_m;
      known.push_back(*above_m[i]);
    }
  }
  const auto typical_m = MedianIfAny(std::move(known));
  if (!typical_m || *typical_m < kLowestFlightM) return false;
  heights.above_ground_m = std::move(above_m);
  heights.takeoff_ellipsoid_m = takeoff_ellipsoid_m;
  heights.is_above_ellipsoid = true;
  heights.sigma_m = 5.0;
  heights.rule_in_words = "absolute height above the take-off as given, flat ground at take-off height";
  return true;
}

// The same over an elevation model that counts from sea level.
bool ByElevationModel(const std::vector<Photo>& photos, const geo::DemSource& dem, FlightHeights& heights) {
  std::vector<double> grounds;
  for (const Photo& photo : photos) {
    if (!photo.position) continue;
    const auto ground_m = dem.GroundHeightM(photo.position->position);
    if (ground_m) grounds.push_back(*ground_m + geo::GeoidHeightM(photo.position->position).value_or(0.0));
  }
  const auto ground_m = MedianIfAny(std::move(grounds));
  if (!ground_m || !ByGivenTakeoff(photos, *ground_m, heights)) return false;
  heights.rule = HeightRule::kElevationModel;
  heights.rule_in_words = "absolute height above the elevation model";
  return true;
}

}  // namespace

std::optional<double> EllipsoidHeightM(const RecordedPosition& position) {
  if (position.height_ellipsoid_m) return position.height_ellipsoid_m;
  if (!position.height_amsl_m) return std::nullopt;
  return *position.height_amsl_m + geo::GeoidHeightM(position.position).value_or(0.0);
}

namespace {

std::size_t CountNear(const geo::LatLon& middle, const std::vector<geo::LatLon>& positions) {
  constexpr double kOneFlightM = 20'000.0;
  return static_cast<std::size_t>(std::count_if(
      positions.begin(), positions.end(),
      [&](const geo::LatLon& position) { return geo::MetresApart(position, middle) < kOneFlightM; }));
}

}  // namespace

std::optional<geo::LatLon> MedianPosition(const std::vector<geo::LatLon>& positions) {
  if (positions.empty()) return std::nullopt;
  std::vector<double> lats;
  std::vector<double> lons;
  const double lon_zero = positions.front().lon_deg;
  for (const geo::LatLon& position : positions) {
    lats.push_back(position.lat_deg);
    // Relative to the first, so that a flight across the date line stays together.
    lons.push_back(std::remainder(position.lon_deg - lon_zero, 360.0));
  }
  const geo::LatLon median{*MedianIfAny(std::move(lats)),
                           std::remainder(lon_zero + *MedianIfAny(std::move(lons)), 360.0)};
  std::size_t most = CountNear(median, positions);
  if (2 * most >= positions.size()) return median;
  // Photos of several places: the median may lie where none is. The position that has most others around it;
  // of thousands some are enough to find it.
  constexpr std::size_t kTried = 500;
  geo::LatLon middle = median;
  const std::size_t step = 1 + positions.size() / kTried;
  for (std::size_t i = 0; i < positions.size(); i += step) {
    const std::size_t near = CountNear(positions[i], positions);
    if (near > most) most = near, middle = positions[i];
  }
  return middle;
}

double GuessHeightFromSpacing(const std::vector<Photo>& photos) {
  return std::clamp(HeightFromSpacing(photos).value_or(60.0), 5.0, 500.0);
}

FlightHeights ChooseHeights(const std::vector<Photo>& photos, const geo::DemSource* dem,
                            const std::optional<double>& takeoff_ellipsoid_m) {
  FlightHeights heights;
  heights.above_ground_m.resize(photos.size());
  std::vector<double> takeoff_heights;
  std::size_t known = 0, above_takeoff = 0;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!photos[i].position) continue;
    heights.above_ground_m[i] = AboveGround(*photos[i].position);
    if (!heights.above_ground_m[i]) continue;
    ++known;
    above_takeoff += photos[i].position->height_above_takeoff_m ? 1 : 0;
    if (const auto ellipsoid_m = EllipsoidHeightM(*photos[i].position)) {
      takeoff_heights.push_back(*ellipsoid_m - *heights.above_ground_m[i]);
    }
  }
  const std::optional<double> takeoff_m = MedianIfAny(takeoff_heights);
  std::optional<double> guessed_above_ground_m;  // only where no photo says it
  if (known > 0) {
    heights.takeoff_ellipsoid_m = takeoff_ellipsoid_m.value_or(takeoff_m.value_or(0.0));
    heights.hangs_on_cameras = takeoff_m && !takeoff_ellipsoid_m;
    heights.is_above_ellipsoid = takeoff_m || takeoff_ellipsoid_m;
    heights.rule_in_words = above_takeoff > 0
                                ? "height above take-off as recorded, flat ground at take-off height"
                                : "height above ground as recorded, flat ground";
    heights.sigma_m = 0.7;
  } else if (takeoff_ellipsoid_m && ByGivenTakeoff(photos, *takeoff_ellipsoid_m, heights)) {
    return heights;
  } else if (dem != nullptr && ByElevationModel(photos, *dem, heights)) {
    return heights;
  } else {
    std::vector<double> ellipsoid_heights;
    for (const Photo& photo : photos) {
      if (!photo.position) continue;
      if (const auto height_m = EllipsoidHeightM(*photo.position)) ellipsoid_heights.push_back(*height_m);
    }
    const double above_ground_m = GuessHeightFromSpacing(photos);
    guessed_above_ground_m = above_ground_m;
    heights.hangs_on_cameras = !ellipsoid_heights.empty();
    heights.is_above_ellipsoid = heights.hangs_on_cameras || takeoff_ellipsoid_m;
    heights.takeoff_ellipsoid_m = MedianIfAny(ellipsoid_heights).value_or(above_ground_m) - above_ground_m;
    if (takeoff_ellipsoid_m && ellipsoid_heights.empty()) heights.takeoff_ellipsoid_m = *takeoff_ellipsoid_m;
    heights.rule = HeightRule::kSpacing;
    heights.rule_in_words = "height above ground guessed from the spacing of the photos";
    heights.sigma_m = 0.3 * above_ground_m;
    heights.assumption = Assumption{flight::RemarkCode::kNoHeights,
                                    {flight::RemarkCode::kHeightBySpacing, {{"height_m", above_ground_m}}},
                                    above_ground_m};
  }
  // Surveyed heights differ far more truly than a barometer's; it only sets their common zero.
  for (std::size_t i = 0; known > 0 && takeoff_m && i < photos.size(); ++i) {
    if (!photos[i].position || !photos[i].position->is_rtk_fixed || !photos[i].position->height_ellipsoid_m)
      continue;
    heights.above_ground_m[i] = *photos[i].position->height_ellipsoid_m - *takeoff_m;
  }
  // Photos without a relative height are tied to the others through their absolute one, or to the take-off as
  // given. Where others are up in the air, one below the take-off is down a slope: only an elevation model
  // knows how far.
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (heights.above_ground_m[i] || !photos[i].position) continue;
    const auto ellipsoid_m = EllipsoidHeightM(*photos[i].position);
    if (ellipsoid_m && (known == 0 || takeoff_m || takeoff_ellipsoid_m)) {
      const double above_ground_m = *ellipsoid_m - takeoff_m.value_or(heights.takeoff_ellipsoid_m);
      if (above_ground_m > 1.0) heights.above_ground_m[i] = above_ground_m;
    } else if (known == 0) {
      heights.above_ground_m[i] = guessed_above_ground_m;
    }
    const auto& below_m = photos[i].position->height_above_takeoff_m;
    if (!heights.above_ground_m[i] && known > 0 && below_m && *below_m < -1.0)
      heights.above_ground_m[i] = below_m;
  }
  return heights;
}

}  // namespace skyquilt::poses
