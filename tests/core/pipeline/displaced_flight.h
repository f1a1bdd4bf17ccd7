// A flight whose truth is known, displaced as a whole, with surveyed points that tell where it belongs. For
// tests of what moves finished flights.
#pragma once

#include <algorithm>
#include <complex>
#include <string>
#include <vector>

#include "core/geo/lat_lon.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/simulate/simulate_flight.h"

namespace skyquilt::pipeline {

using Complex = std::complex<double>;

inline constexpr double kGroundZ = 0.0;

// How a finished flight is wrong as a whole.
struct Displacement {
  double turn_rad = 0.0;
  double scale = 1.0;
  Complex shift_m;
};

struct Displaced {
  simulate::SimulatedFlight truth;
  FlightFacts known;

  explicit Displaced(const Displacement& by) {
    simulate::SimulateOptions options;
    options.trajectory.photos = 20;
    truth = *simulate::PlanSimulatedFlight(options);
    known.flight.frame = truth.frame;
    known.appearance = MapAppearance{};
    for (const simulate::SimulatedPhoto& real : truth.photos) {
      alignment::AlignedPhoto photo;
      photo.photo = real.photo;
      photo.intrinsics = truth.options.intrinsics;
      const Eigen::Vector3d center = real.pose.cam_from_enu.TargetOriginInSource();
      const Complex place = std::polar(by.scale, by.turn_rad) * Complex(center.x(), center.y()) + by.shift_m;
      photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
          real.pose.cam_from_enu.rotation *
              Eigen::Quaterniond(Eigen::AngleAxisd(-by.turn_rad, Eigen::Vector3d::UnitZ())),
          {place.real(), place.imag(), kGroundZ + by.scale * (center.z() - kGroundZ)});
      photo.height_above_ground_m = photo.cam_from_enu.TargetOriginInSource().z();
      photo.placement = alignment::Placement::kAligned;
      photo.error_radius_m = 1.5;
      known.flight.photos.push_back(photo);
    }
  }

  // Surveyed where they truly are, marked in every photo that shows them; the first may be surveyed wrongly.
  std::vector<flight::GcpList> Survey(std::size_t points,
                                      const Eigen::Vector3d& first_off_by = {0, 0, 0}) const {
    const Eigen::Vector3d places[] = {
        {-25.0, -30.0, 0.0}, {25.0, 30.0, 0.0}, {-20.0, 25.0, 0.0}, {22.0, -28.0, 0.0}, {0.0, 0.0, 0.0}};
    flight::GcpList list;
    list.file_name = "gcp_list.txt";
    for (std::size_t k = 0; k < points; ++k) {
      const geo::Wgs84 place =
          truth.frame.Wgs84FromEnu(k == 0 ? Eigen::Vector3d(places[k] + first_off_by) : places[k]);
      list.points.push_back({.name = "point" + std::to_string(k),
                             .position = {place.lat_deg, place.lon_deg},
                             .height_m = place.height_ellipsoid_m,
                             .height = std::nullopt});
      for (const simulate::SimulatedPhoto& photo : truth.photos) {
        const auto pixel = truth.options.intrinsics.Project(photo.pose.cam_from_enu * places[k]);
        if (pixel && truth.options.intrinsics.IsInImage(*pixel)) {
          list.sightings.push_back({photo.photo.name, pixel->x() + 0.5, pixel->y() + 0.5, k});
        }
      }
    }
    return {list};
  }

  double WorstCameraM(const FlightFacts& facts) const {
    double worst_m = 0.0;
    for (std::size_t i = 0; i < truth.photos.size(); ++i) {
      worst_m = std::max(worst_m, (facts.flight.photos[i].cam_from_enu.TargetOriginInSource() -
                                   truth.photos[i].pose.cam_from_enu.TargetOriginInSource())
                                      .norm());
    }
    return worst_m;
  }

  double WorstTurnRad(const FlightFacts& facts) const {
    double worst_rad = 0.0;
    for (std::size_t i = 0; i < truth.photos.size(); ++i) {
      worst_rad = std::max(worst_rad, facts.flight.photos[i].cam_from_enu.rotation.angularDistance(
                                          truth.photos[i].pose.cam_from_enu.rotation));
    }
    return worst_rad;
  }
};

}  // namespace skyquilt::pipeline
