#include "core/poses/plausible_poses.h"

#include <algorithm>
#include <cmath>

#include "core/base/median.h"
#include "core/camera/footprint.h"
#include "core/flight/remarks/remark_words.h"

namespace skyquilt::poses {
namespace {

using flight::Remark;
using flight::RemarkCode;

constexpr double kMinHeightM = 0.5;  // above the ground: a drone about to land
// Further from the middle of the flight its flat ground leaves the Earth by more than the drone is high.
constexpr double kFarthestM = 50'000.0;
// From the frame's origin: no two points of the Earth lie further apart.
constexpr double kEarthM = 13e6;
// Of the focal length, in widths of the picture: from a view of 179 degrees to one of four minutes of arc.
constexpr double kMinFocalWidths = 0.005;
constexpr double kMaxFocalWidths = 1000.0;
// Of what a photo in the middle of the flight shows. Looking as far towards the horizon as is ever drawn
// shows some 60 times the ground of looking down, a climb to five times the height 25 times.
constexpr double kMaxTimesTheGround = 400.0;
// Of the map, at the resolution of a photo in the middle of the flight: half of what is ever drawn of one
// photo, since tiles may be finer. One recorded a kilometre too high comes to that.
constexpr double kMaxPixels = 20'000.0 * (1 << 20) / 2.0;

bool IsFocalLength(double focal_px, const camera::Intrinsics& lens) {
  const double widths = focal_px / std::max(1, lens.width_px);
  return widths > kMinFocalWidths && widths < kMaxFocalWidths;
}

bool IsOnEarth(const CameraStand& stand) {
  const camera::Intrinsics& lens = stand.intrinsics;
  return stand.cam_from_enu.rotation.coeffs().allFinite() &&
         stand.cam_from_enu.translation.norm() < kEarthM && std::abs(stand.height_above_ground_m) < kEarthM &&
         IsFocalLength(lens.focal_x_px, lens) && IsFocalLength(lens.focal_y_px, lens) &&
         std::isfinite(lens.center_x_px) && std::isfinite(lens.center_y_px) &&
         std::isfinite(lens.k1 + lens.k2 + lens.k3 + lens.p1 + lens.p2);
}

double GroundSeenM2(const CameraStand& stand) {
  const double plane_z_m = stand.cam_from_enu.TargetOriginInSource().z() - stand.height_above_ground_m;
  const auto polygon = camera::GroundFootprint(stand.intrinsics, stand.cam_from_enu, plane_z_m);
  if (polygon.empty()) return 0.0;
  const geo::Bounds2 bounds = camera::BoundsOf(polygon);
  return bounds.Width() * bounds.Height();
}

}  // namespace

std::vector<std::optional<Remark>> WhyImplausible(const std::vector<CameraStand>& stands,
                                                  const geo::LocalFrame& frame) {
  std::vector<std::optional<Remark>> why(stands.size());
  std::vector<Eigen::Vector2d> places;
  for (std::size_t i = 0; i < stands.size(); ++i) {
    if (!IsOnEarth(stands[i])) {
      why[i] = RemarkCode::kLeftNoNumbers;
      continue;
    }
    places.emplace_back(stands[i].cam_from_enu.TargetOriginInSource().head<2>());
  }
  if (places.empty()) return why;
  const Eigen::Vector2d middle = MedianByAxis(places);
  std::vector<double> seen_m2(stands.size(), 0.0), some_m2, pixels_m2;
  for (std::size_t i = 0; i < stands.size(); ++i) {
    if (why[i]) continue;
    const Eigen::Vector3d center = stands[i].cam_from_enu.TargetOriginInSource();
    const double height_m = stands[i].height_above_ground_m;
    const double far_m = (center.head<2>() - middle).norm();
    const double lat_deg = frame.Wgs84FromEnu(center).lat_deg;
    if (far_m > kFarthestM) {
      why[i] = Remark{RemarkCode::kLeftFarFromFlight, {{"apart_km", far_m / 1000.0}}};
    } else if (!(std::abs(lat_deg) <= kHighestLatDeg)) {
      why[i] = Remark{RemarkCode::kLeftBeyondMaps, {{"lat_deg", lat_deg}, {"highest_deg", kHighestLatDeg}}};
    } else if (height_m < kMinHeightM) {
      why[i] = Remark{height_m < 0.0 ? RemarkCode::kLeftBelowGround : RemarkCode::kLeftOnTheGround,
                      {{"height_m", std::abs(height_m)}}};
    } else {
      seen_m2[i] = GroundSeenM2(stands[i]);
      if (seen_m2[i] > 0.0) some_m2.push_back(seen_m2[i]);
      pixels_m2.push_back(std::pow(height_m / stands[i].intrinsics.MeanFocalPx(), 2));
    }
  }
  if (some_m2.empty()) return why;
  const double typical_m2 = Median(std::move(some_m2));
  const double most_m2 = std::min(kMaxTimesTheGround * typical_m2, kMaxPixels * Median(std::move(pixels_m2)));
  for (std::size_t i = 0; i < stands.size(); ++i) {
    if (seen_m2[i] <= most_m2) continue;
    why[i] = Remark{RemarkCode::kLeftTooMuchGround,
                    {{"times", seen_m2[i] / typical_m2}, {"height_m", stands[i].height_above_ground_m}}};
  }
  return why;
}

Remark FirstImplausible(const std::vector<flight::LeftOutPhoto>& left_out) {
  constexpr std::size_t kNamed = 3;
  std::vector<Remark> first;
  for (std::size_t i = 0; i < std::min(kNamed, left_out.size()); ++i)
    first.push_back({RemarkCode::kPhotoDoes, {{"photo", left_out[i].name}, {"said", left_out[i].reason}}});
  if (left_out.size() > kNamed)
    first.push_back({RemarkCode::kSoWithMore, {{"photos", left_out.size() - kNamed}}});
  return flight::InARow(std::move(first));
}

}  // namespace skyquilt::poses
