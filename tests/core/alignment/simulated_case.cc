#include "tests/core/alignment/simulated_case.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>

#include "core/base/check.h"
#include "core/base/median.h"
#include "core/poses/estimate_poses.h"
#include "core/simulate/world/random.h"

namespace skyquilt::alignment {
namespace {

using Complex = std::complex<double>;

constexpr int kPixelsAcross = 5;

struct SeenPoint {
  Complex now, truth;
  std::size_t photo = 0;
};

std::vector<SeenPoint> Observe(const simulate::SimulatedFlight& truth, const AlignedFlight& flight,
                               const ground::GroundSurface& surface) {
  std::map<std::string, const simulate::SimulatedPhoto*> by_name;
  for (const simulate::SimulatedPhoto& photo : truth.photos) by_name[photo.photo.name] = &photo;
  // The aligned flight has its own local frame; both tell WGS84.
  const geo::Rigid3 truth_from_flight = truth.frame.ecef_from_enu().Inverse() * flight.frame.ecef_from_enu();
  std::vector<SeenPoint> seen;
  for (std::size_t i = 0; i < flight.photos.size(); ++i) {
    const AlignedPhoto& photo = flight.photos[i];
    const simulate::SimulatedPhoto& real = *by_name.at(photo.photo.name);
    const camera::Intrinsics& lens = truth.options.intrinsics;
    for (int y = 0; y < kPixelsAcross; ++y) {
      for (int x = 0; x < kPixelsAcross; ++x) {
        const Eigen::Vector2d pixel((x + 0.5) / kPixelsAcross * lens.width_px - 0.5,
                                    (y + 0.5) / kPixelsAcross * lens.height_px - 0.5);
        const Eigen::Vector3d start = photo.cam_from_enu.TargetOriginInSource();
        const Eigen::Vector3d ray =
            photo.cam_from_enu.rotation.conjugate() * photo.intrinsics.Unproject(pixel);
        if (ray.z() > -0.1) continue;
        Eigen::Vector3d point = start;
        double z = surface.MeanHeight();
        for (int k = 0; k < 8; ++k) {
          point = start + (z - start.z()) / ray.z() * ray;
          z = surface.HeightAt(point.head<2>());
        }
        const Eigen::Vector3d in_truth = truth_from_flight * point;
        const auto hit = truth.world.CastRay(
            real.pose.cam_from_enu.TargetOriginInSource(),
            (real.pose.cam_from_enu.rotation.conjugate() * lens.Unproject(pixel)).normalized(), 2000.0);
        if (!hit) continue;
        seen.push_back({{in_truth.x(), in_truth.y()}, {hit->point_in_enu.x(), hit->point_in_enu.y()}, i});
      }
    }
  }
  return seen;
}

// Moves what was seen by the similarity of the plane that brings it nearest to the truth.
void MoveOntoTruth(std::vector<SeenPoint>& seen) {
  Complex mean_now, mean_truth;
  for (const SeenPoint& one : seen) {
    mean_now += one.now / static_cast<double>(seen.size());
    mean_truth += one.truth / static_cast<double>(seen.size());
  }
  Complex cross;
  double square = 0.0;
  for (const SeenPoint& one : seen) {
    cross += std::conj(one.now - mean_now) * (one.truth - mean_truth);
    square += std::norm(one.now - mean_now);
  }
  const Complex turn = cross / square;
  for (SeenPoint& one : seen) one.now = turn * (one.now - mean_now) + mean_truth;
}

std::vector<double> MissesM(const std::vector<SeenPoint>& seen) {
  std::vector<double> errors_m;
  for (const SeenPoint& one : seen) errors_m.push_back(std::abs(one.now - one.truth));
  return errors_m;
}

std::vector<double> MedianOfEachPhoto(const std::vector<SeenPoint>& seen, std::size_t photos) {
  std::vector<std::vector<double>> errors_m(photos);
  for (const SeenPoint& one : seen) errors_m[one.photo].push_back(std::abs(one.now - one.truth));
  std::vector<double> errors;
  for (const std::vector<double>& of_photo : errors_m) errors.push_back(Percentile(of_photo, 0.5));
  return errors;
}

}  // namespace

std::vector<double> PhotoErrorsM(const simulate::SimulatedFlight& truth, const AlignedFlight& flight,
                                 const ground::GroundSurface& surface) {
  return MedianOfEachPhoto(Observe(truth, flight, surface), flight.photos.size());
}

std::vector<double> RelativePhotoErrorsM(const simulate::SimulatedFlight& truth, const AlignedFlight& flight,
                                         const ground::GroundSurface& surface) {
  std::vector<SeenPoint> seen = Observe(truth, flight, surface);
  MoveOntoTruth(seen);
  return MedianOfEachPhoto(seen, flight.photos.size());
}

GroundError MeasureGroundError(const simulate::SimulatedFlight& truth, const AlignedFlight& flight,
                               const ground::GroundSurface& surface, const std::set<std::string>& without) {
  std::vector<SeenPoint> seen = Observe(truth, flight, surface);
  std::erase_if(seen,
                [&](const SeenPoint& one) { return without.contains(flight.photos[one.photo].photo.name); });
  GroundError error;
  error.absolute_ce90_m = Percentile(MissesM(seen), 0.9);
  MoveOntoTruth(seen);
  error.relative_ce90_m = Percentile(MissesM(seen), 0.9);
  const std::vector<double> photos = PhotoErrorsM(truth, flight, surface);
  error.worst_photo_m = photos.empty() ? 0.0 : *std::max_element(photos.begin(), photos.end());
  return error;
}

GnssError MeasureGnssError(const simulate::SimulatedFlight& truth, const std::set<std::string>& without) {
  std::vector<double> errors_m;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const simulate::SimulatedPhoto& photo : truth.photos) {
    if (!photo.recorded.position || without.contains(photo.photo.name)) continue;
    const Eigen::Vector2d error =
        (truth.frame.EnuFromWgs84(*photo.recorded.position) - photo.pose.cam_from_enu.TargetOriginInSource())
            .head<2>();
    errors_m.push_back(error.norm());
    mean += error;
  }
  if (errors_m.empty()) return {};
  return {Percentile(errors_m, 0.9), mean.norm() / static_cast<double>(errors_m.size())};
}

std::vector<ControlPoint> SurveyControl(const simulate::SimulatedFlight& truth) {
  constexpr double kOtherZeroM = -47.3;
  constexpr double kMarkSigmaPx = 0.5;
  constexpr std::size_t kMaxSightings = 6;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = Eigen::Vector2d::Constant(-1e9);
  for (const simulate::SimulatedPhoto& photo : truth.photos) {
    const Eigen::Vector2d at = photo.pose.cam_from_enu.TargetOriginInSource().head<2>();
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  simulate::RandomStream random(truth.options.seed, 977);
  std::vector<ControlPoint> control;
  const double places[5][2] = {{0.05, 0.05}, {0.95, 0.1}, {0.9, 0.95}, {0.1, 0.9}, {0.5, 0.5}};
  for (const auto& [east_share, north_share] : places) {
    const double east = low.x() + east_share * (high.x() - low.x());
    const double north = low.y() + north_share * (high.y() - low.y());
    const Eigen::Vector3d point(east, north, truth.world.SurfaceHeightAt(east, north));
    const geo::Wgs84 place = truth.frame.Wgs84FromEnu(point);
    ControlPoint surveyed;
    surveyed.name = "point" + std::to_string(control.size() + 1);
    surveyed.position = {place.lat_deg, place.lon_deg};
    surveyed.height_m = place.height_ellipsoid_m + kOtherZeroM;
    for (const simulate::SimulatedPhoto& photo : truth.photos) {
      if (surveyed.sightings.size() >= kMaxSightings) break;
      const auto pixel = truth.options.intrinsics.Project(photo.pose.cam_from_enu * point);
      if (!pixel || !truth.options.intrinsics.IsInImage(*pixel)) continue;
      const Eigen::Vector2d marked = *pixel + kMarkSigmaPx * Eigen::Vector2d(random.Gauss(), random.Gauss());
      if (truth.options.intrinsics.IsInImage(marked))
        surveyed.sightings.push_back({photo.photo.name, marked});
    }
    control.push_back(std::move(surveyed));
  }
  return control;
}

poses::PosedFlight PosesOf(const simulate::SimulatedFlight& truth) {
  flight::Flight flight;
  for (const simulate::SimulatedPhoto& photo : truth.photos) flight.photos.push_back(photo.photo);
  Result<poses::PosedFlight> posed = poses::EstimatePoses(flight, {});
  SKYQUILT_CHECK(posed.ok(), "simulated flights have poses");
  return *std::move(posed);
}

simulate::SimulatedFlight SmallTruth(int photos, double relief_m) {
  simulate::SimulateOptions options;
  options.seed = options.world.seed = 5;
  options.world.relief_m = relief_m;
  options.noise = simulate::NoiseClass::kXmpTypical;
  options.intrinsics = camera::Intrinsics::Centered(800, 600, 750.0);
  options.trajectory.photos = photos;
  options.trajectory.photos_per_line = 4;
  return *simulate::PlanSimulatedFlight(options);
}

}  // namespace skyquilt::alignment
