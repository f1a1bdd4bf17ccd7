// A flight with all that its map is judged by, for tests of that judgement.
#pragma once

#include <array>
#include <string>

#include "core/alignment/scene/ground_control.h"
#include "core/pipeline/report/judge_map.h"

namespace skyquilt::pipeline {

// Photos on a grid, aligned where the best move of the recorded positions puts them, as alignment does.
struct JudgedFlight {
  alignment::AlignedFlight flight;
  poses::PoseReport poses;
  alignment::AlignReport report;

  explicit JudgedFlight(int photos) {
    flight.frame = geo::LocalFrame({46.8, 7.1, 500.0});
    report.tie_points = 1000;
    report.residual_rms_px = 0.5;
    for (int i = 0; i < photos; ++i) {
      alignment::AlignedPhoto photo;
      photo.photo.name = "p" + std::to_string(i);
      photo.placement = alignment::Placement::kAligned;
      photo.error_radius_m = 9.0;
      flight.photos.push_back(photo);
      Stand(static_cast<std::size_t>(i), {20.0 * (i % 6), 20.0 * (i / 6)});
      Record(static_cast<std::size_t>(i), {20.0 * (i % 6), 20.0 * (i / 6)});
    }
  }

  void Stand(std::size_t i, const Eigen::Vector2d& place) {
    flight.photos[i].cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond::Identity(),
                                                                             {place.x(), place.y(), 60.0});
  }
  void Record(std::size_t i, const Eigen::Vector2d& place) {
    const geo::Wgs84 at = flight.frame.Wgs84FromEnu({place.x(), place.y(), 60.0});
    flight.photos[i].photo.position.emplace().position = {at.lat_deg, at.lon_deg};
  }
  void Refute(std::size_t i) {
    alignment::AlignPhotoReport& refuted = report.photo_reports.emplace_back();
    refuted.name = "p" + std::to_string(i);
    refuted.faults = {alignment::PhotoFault::kPositionWrong};
  }
  // Recorded as far off where it stands as the pictures do not believe.
  void Misplace(std::size_t i, const Eigen::Vector2d& by) {
    Record(i, Eigen::Vector2d(flight.photos[i].cam_from_enu.TargetOriginInSource().head<2>()) + by);
    Refute(i);
  }
  void Surveyed(bool is_check, double east_m, double north_m, bool is_predicted = false) {
    alignment::ControlReport point;
    point.is_used = true;
    point.is_check = is_check;
    // Spread as the photos are: the first five stand at four corners and the middle.
    const std::array<Eigen::Vector2d, 5> places = {
        {{50.0, 20.0}, {0.0, 0.0}, {100.0, 0.0}, {0.0, 40.0}, {100.0, 40.0}}};
    const Eigen::Vector2d& place = places[report.control.size() % places.size()];
    const geo::Wgs84 at = flight.frame.Wgs84FromEnu({place.x(), place.y(), 0.0});
    point.surveyed = {at.lat_deg, at.lon_deg};
    point.sightings = 4;
    point.miss_east_m = east_m;
    point.miss_north_m = north_m;
    if (is_predicted) point.left_out = alignment::ControlPrediction{east_m, north_m, 0.0};
    report.control.push_back(point);
  }
  JudgedMap Map() const {
    return {.flight = flight, .poses = poses, .alignment = &report, .gsd_m = 0.02, .photo_gsd_m = 0.02};
  }
  MapQuality Judge() const { return JudgeMap(Map()); }
};

}  // namespace skyquilt::pipeline
