#include "core/pipeline/placing/check_records.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/flight/remarks/because.h"
#include "core/geo/crs/reference_system.h"
#include "core/geo/lat_lon.h"
#include "core/render/plan_mosaic.h"

namespace skyquilt::pipeline {
namespace {

template <typename Flight>
Result<void> CheckUtm(const Flight& flight, const MosaicOptions& options) {
  const bool is_wanted = options.write_utm || options.heights != MapHeights::kNone;
  if (!is_wanted || flight.photos.empty()) return {};
  for (const auto& photo : flight.photos) {
    const geo::Wgs84 at = flight.frame.Wgs84FromEnu(photo.cam_from_enu.TargetOriginInSource());
    if (geo::IsWithinUtm({at.lat_deg, at.lon_deg})) return {};
  }
  return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFailBeyondUtm);
}

}  // namespace

// Recorded places may be wrong, so that only what is far away is refused here; PlanMosaic refuses the rest.
Result<void> CheckBoundaryIsNear(const poses::PosedFlight& posed, const geo::Boundary& boundary) {
  constexpr double kMetresPerDegree = 111'320.0;
  constexpr double kFarM = 5'000.0, kFarInHeights = 20.0;
  if (!posed.is_placed || posed.photos.empty()) return {};
  const geo::LatLonBounds bounds = boundary.Bounds();
  const geo::LatLon middle = bounds.Middle();
  for (const poses::PosedPhoto& photo : posed.photos) {
    const geo::Wgs84 at = posed.frame.Wgs84FromEnu(photo.cam_from_enu.TargetOriginInSource());
    const double far_deg =
        (kFarM + kFarInHeights * std::max(0.0, photo.height_above_ground_m)) / kMetresPerDegree;
    const double far_lon_deg = far_deg / std::max(0.05, std::cos(geo::DegToRad(at.lat_deg)));
    const double beyond_lat_deg =
        std::abs(at.lat_deg - middle.lat_deg) - 0.5 * (bounds.north_deg - bounds.south_deg);
    const double beyond_lon_deg = std::abs(std::remainder(at.lon_deg - middle.lon_deg, 360.0)) -
                                  0.5 * (bounds.east_deg - bounds.west_deg);
    if (!(beyond_lat_deg > far_deg || beyond_lon_deg > far_lon_deg)) return {};
  }
  const geo::Wgs84& origin = posed.frame.origin();
  return render::BoundaryElsewhere(boundary, {origin.lat_deg, origin.lon_deg});
}

Result<void> CheckUtmByRecords(const poses::PosedFlight& posed, const MosaicOptions& options) {
  return posed.is_placed ? CheckUtm(posed, options) : Result<void>();
}

Result<void> CheckUtmOfPlaced(const alignment::AlignedFlight& flight, const MosaicOptions& options) {
  return CheckUtm(flight, options);
}

Result<void> CheckGsdByRecords(const poses::PosedFlight& posed, const MosaicOptions& options) {
  std::vector<double> gsds_m;
  for (const poses::PosedPhoto& photo : posed.photos)
    gsds_m.push_back(photo.height_above_ground_m / photo.photo.intrinsics.MeanFocalPx());
  std::erase_if(gsds_m, [](double gsd_m) { return !(gsd_m > 0.0 && std::isfinite(gsd_m)); });
  if (!posed.is_placed || gsds_m.empty()) return {};
  return options.CheckGsd(Median(std::move(gsds_m)));
}

}  // namespace skyquilt::pipeline
