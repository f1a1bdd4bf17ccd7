#include "core/poses/estimate_poses.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "core/geo/geoid.h"
#include "core/poses/choose_convention.h"
#include "core/poses/flight_heights.h"
#include "core/poses/join_logs.h"
#include "core/poses/photo_rows.h"
#include "core/poses/place_by_log.h"
#include "core/poses/place_by_records.h"
#include "core/poses/takeoff.h"
#include "core/poses/time_sync.h"

namespace skyquilt::poses {
namespace {

using flight::LeftOutPhoto;
using flight::Photo;

// A log covers a photo up to this long before its first and after its last sample.
constexpr double kBeyondLogS = 1.0;

class Estimation {
 public:
  Estimation(const flight::Flight& flight, const EstimatePosesOptions& options)
      : flight_(flight), options_(options), photos_(flight.photos) {
    posed_.left_out = flight.left_out;
    posed_.warnings = flight.warnings;
  }

  Result<PosedFlight> Run() {
    PoseReport& report = posed_.report;
    report.logs = ApplyPhotoRows(flight_.logs, photos_);
    log_ = JoinLogs(flight_.logs);
    if (log_) TieToLog();
    ChooseReading();
    if (!by_log_.empty()) {
      if (auto placed = PlaceOnLog(); !placed) {
        Warn("The log could not be used: " + placed.error().message);
        by_log_.clear();
      }
    }
    PlaceTheRest();
    if (posed_.photos.empty()) return NothingPlaced();
    if (options_.dem != nullptr) LayOnElevationModel();
    Summarise();
    return std::move(posed_);
  }

 private:
  void Warn(std::string text) { posed_.warnings.push_back(std::move(text)); }

  bool HasTrackSeries() const {
    return !log_->log.imu.empty() || !log_->log.attitude.empty() || log_->log.gnss.size() >= 2;
  }

  // Finds the photos' times on the log's clock and those that its series cover.
  void TieToLog() {
    PoseReport& report = posed_.report;
    report.logs.insert(report.logs.end(), log_->notes.begin(), log_->notes.end());
    for (const std::string& warning : log_->warnings) Warn(warning);
    if (photos_.empty()) return;
    const auto sync = MatchPhotosToLog(photos_, log_->log);
    if (!sync) {
      Warn(sync.error().message + ".");
      return;
    }
    report.time_match = sync->method_in_words;
    for (const std::string& note : sync->notes) report.time_match += "; " + note;
    report.time_offset_s = sync->offset_s;
    report.time_sigma_s = sync->sigma_s;
    report.camera_ahead_of_utc_s = sync->camera_ahead_of_utc_s;
    clock_sigma_s_ = sync->sigma_s;
    ApplyEvents(log_->log, *sync, log_->log.gnss.size() >= 2, photos_);
    if (!HasTrackSeries()) return;
    const auto [begin_s, end_s] = LogSpan();
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      const auto& time = sync->photos[i];
      if (!time || time->t_s < begin_s - kBeyondLogS || time->t_s > end_s + kBeyondLogS) continue;
      PhotoAtTime at;
      at.photo = &photos_[i];
      at.t_s = time->t_s;
      at.sigma_s =
          time->event
              ? time->sigma_s
              : std::sqrt(std::max(0.0, time->sigma_s * time->sigma_s - sync->sigma_s * sync->sigma_s));
      if (photos_[i].position) at.height_above_ground_m = photos_[i].position->height_above_takeoff_m;
      // Event times are the log's own: the camera clock's offset does not enter them.
      any_by_clock_ = any_by_clock_ || !time->event;
      by_log_.push_back(at);
    }
    std::stable_sort(by_log_.begin(), by_log_.end(),
                     [](const PhotoAtTime& a, const PhotoAtTime& b) { return a.t_s < b.t_s; });
  }

  void ChooseReading() {
    std::vector<std::optional<double>> airframe_yaw(photos_.size());
    for (const PhotoAtTime& p : by_log_) {
      airframe_yaw[static_cast<std::size_t>(p.photo - photos_.data())] = AirframeYawAt(p.t_s);
    }
    const ConventionChoice choice = ChooseConvention(photos_, airframe_yaw);
    posed_.report.convention = choice.words;
    if (choice.is_changed)
      Warn("As recorded, the camera angles would not show the ground: " + choice.words + ".");
  }

  std::optional<double> AirframeYawAt(double t_s) const {
    const auto& samples = log_->log.attitude;
    const auto next = std::lower_bound(samples.begin(), samples.end(), t_s,
                                       [](const flight::AttitudeSample& s, double t) { return s.t_s < t; });
    if (next == samples.end() || !next->has_yaw || next->t_s - t_s > 1.0) return std::nullopt;
    const Eigen::Vector3d nose = next->ned_from_body * Eigen::Vector3d::UnitX();
    return std::atan2(nose.y(), nose.x());
  }

  std::pair<double, double> LogSpan() const {
    double begin_s = 1e18;
    double end_s = -1e18;
    const auto take = [&](const auto& samples) {
      if (samples.empty()) return;
      begin_s = std::min(begin_s, samples.front().t_s);
      end_s = std::max(end_s, samples.back().t_s);
    };
    take(log_->log.gnss);
    take(log_->log.attitude);
    take(log_->log.imu);
    return {begin_s, end_s};
  }

  Result<void> PlaceOnLog() {
    std::vector<std::pair<double, const Photo*>> photos_at;
    for (const PhotoAtTime& p : by_log_) photos_at.emplace_back(p.t_s, p.photo);
    Takeoff takeoff = FindTakeoff(log_->log, photos_at);
    const geo::LatLon middle = takeoff.middle.value_or(options_.origin.value_or(geo::LatLon{}));
    frame_ = geo::LocalFrame({middle.lat_deg, middle.lon_deg, takeoff.height_ellipsoid_m});
    takeoff_ = takeoff.position ? takeoff.position : options_.origin;
    PlaceByLogOptions options;
    options.clock_sigma_s = any_by_clock_ ? clock_sigma_s_ : 0.005;
    options.landed_at_start = options_.landed_at_start;
    options.ground_z_in_enu_m = takeoff.ground_above_takeoff_m;
    options.height_sigma_m = takeoff.sigma_m;
    auto placed = PlaceByLog(by_log_, log_->log, *frame_, options);
    if (!placed) {
      frame_.reset();
      return placed.error();
    }
    posed_.ground_z_in_enu_m = takeoff.ground_above_takeoff_m;
    posed_.photos = std::move(placed->photos);
    posed_.is_placed = placed->is_placed || options_.origin.has_value();
    for (const std::string& warning : placed->warnings) Warn(warning);
    for (const std::string& warning : takeoff.warnings) Warn(warning);
    PoseReport& report = posed_.report;
    report.height_rule = takeoff.rule;
    report.series = std::move(placed->series);
    report.knots = placed->knots;
    report.iterations = placed->iterations;
    report.photos_by_log = static_cast<int>(posed_.photos.size());
    report.method = "smoothed track of the log";
    if (!placed->is_placed) WarnAboutReckoning();
    return {};
  }

  void WarnAboutReckoning() {
    posed_.report.method = "reckoned from the start without any position";
    if (options_.origin) {
      Warn(
          "No position anywhere: the flight is reckoned from the given origin, and its error grows with "
          "time.");
    } else {
      Warn(
          "No position anywhere: the map has the right scale and north, but its place on Earth is not known; "
          "it is "
          "drawn at 0 degrees north, 0 degrees east. Give --origin LAT,LON of the take-off to place it.");
    }
  }

  // Photos outside the log, or all of them without one.
  void PlaceTheRest() {
    std::vector<Photo> rest;
    for (const Photo& photo : photos_) {
      const bool is_on_log = std::any_of(by_log_.begin(), by_log_.end(),
                                         [&](const PhotoAtTime& p) { return p.photo == &photo; });
      if (is_on_log) continue;
      if (photo.position) {
        rest.push_back(photo);
      } else {
        posed_.left_out.push_back({photo.name, ErrorCode::kNoPosition, WhyWithoutPosition()});
      }
    }
    if (rest.empty()) return;
    const FlightHeights heights = ChooseHeights(rest, options_.dem);
    for (const std::string& warning : heights.warnings) Warn(warning);
    if (posed_.report.height_rule.empty()) posed_.report.height_rule = heights.rule;
    if (!frame_) {
      std::vector<geo::LatLon> positions;
      for (const Photo& photo : rest) positions.push_back(photo.position->position);
      const geo::LatLon middle = *MedianPosition(positions);
      frame_ = geo::LocalFrame({middle.lat_deg, middle.lon_deg, heights.takeoff_ellipsoid_m});
    }
    PlacedByRecords placed = PlaceByRecords(rest, heights, *frame_);
    if (placed.without_angles > 0) {
      Warn(fmt::format(
          "{} of {} photos recorded no camera angles: they are taken as looking straight down, turned along "
          "the flight's course.",
          placed.without_angles, placed.photos.size()));
    }
    posed_.report.photos_by_records = static_cast<int>(placed.photos.size());
    if (posed_.report.method.empty()) posed_.report.method = "what the photos record of themselves";
    std::move(placed.photos.begin(), placed.photos.end(), std::back_inserter(posed_.photos));
    std::move(placed.left_out.begin(), placed.left_out.end(), std::back_inserter(posed_.left_out));
  }

  std::string WhyWithoutPosition() const {
    if (!log_) {
      return "has no position: no GPS in its EXIF or XMP and no log that covers it. Add the flight log or a "
             "geo.txt with "
             "its position.";
    }
    return "has no position: no GPS in its EXIF or XMP, and the log does not cover the time it was taken. "
           "Add the log of "
           "its flight or a geo.txt with its position.";
  }

  Error NothingPlaced() const {
    for (const LeftOutPhoto& left : posed_.left_out) {
      if (left.reason.find("usable height") != std::string::npos) {
        return {ErrorCode::kUnprocessable, "no photo has a usable height above the ground", ""};
      }
    }
    std::string message =
        "none of the files is a photo with a position, so there is nothing to place on the ground. Check "
        "that "
        "the photos come straight from the drone (editing and messengers remove GPS data), or add the flight "
        "log.";
    if (log_ && !photos_.empty()) {
      message =
          "no photo could be tied to the log, and none has a position of its own, so there is nothing to "
          "place "
          "on the ground.";
      for (std::size_t k = flight_.warnings.size(); k < posed_.warnings.size(); ++k)
        message += " " + posed_.warnings[k];
    }
    return {ErrorCode::kUnprocessable, message, ""};
  }

  // Heights above take-off become heights above the ground below each photo.
  void LayOnElevationModel() {
    const auto& dem = *options_.dem;
    const auto latlon = [&](const Eigen::Vector3d& point) {
      const geo::Wgs84 at = frame_->Wgs84FromEnu(point);
      return geo::LatLon{at.lat_deg, at.lon_deg};
    };
    const bool is_absolute = posed_.report.height_rule.find("elevation model") != std::string::npos;
    if (!posed_.is_placed) return;
    const geo::LatLon start =
        takeoff_.value_or(latlon(posed_.photos.front().cam_from_enu.TargetOriginInSource()));
    std::optional<double> zero_m = dem.GroundHeightM(start);
    if (is_absolute) {
      const geo::Wgs84& origin = frame_->origin();
      zero_m = origin.height_ellipsoid_m - geo::GeoidHeightM({origin.lat_deg, origin.lon_deg}).value_or(0.0);
    }
    if (!zero_m) {
      Warn("The elevation model does not cover the place of take-off; the ground is taken as flat.");
      return;
    }
    std::vector<double> grounds;
    for (PosedPhoto& photo : posed_.photos) {
      const Eigen::Vector3d center = photo.cam_from_enu.TargetOriginInSource();
      const auto ground_m = dem.GroundHeightM(latlon(center));
      if (!ground_m) continue;
      grounds.push_back(*ground_m - *zero_m);
      photo.height_above_ground_m = center.z() - grounds.back();
    }
    if (2 * grounds.size() < posed_.photos.size()) {
      Warn("The elevation model covers less than half of the photos; the ground is taken as flat.");
      return;
    }
    const auto middle = grounds.begin() + static_cast<std::ptrdiff_t>(grounds.size() / 2);
    std::nth_element(grounds.begin(), middle, grounds.end());
    posed_.ground_z_in_enu_m = *middle;
    if (is_absolute) return;
    posed_.report.height_rule +=
        fmt::format("; the elevation model puts the ground {:+.1f} m from {}", *middle,
                    takeoff_ ? "take-off" : "the first photo, taken for take-off");
  }

  void Summarise() {
    posed_.frame = *frame_;
    PoseReport& report = posed_.report;
    report.is_placed = posed_.is_placed;
    std::vector<double> radii;
    for (const PosedPhoto& photo : posed_.photos) radii.push_back(photo.error_radius_m);
    std::sort(radii.begin(), radii.end());
    report.median_error_radius_m = radii[radii.size() / 2];
    report.largest_error_radius_m = radii.back();
    std::sort(posed_.left_out.begin(), posed_.left_out.end(),
              [](const LeftOutPhoto& a, const LeftOutPhoto& b) { return a.name < b.name; });
  }

  const flight::Flight& flight_;
  const EstimatePosesOptions& options_;
  std::vector<Photo>
      photos_;  // with what lists and events say of them; never resized, by_log_ points into it
  std::optional<JoinedLog> log_;
  std::vector<PhotoAtTime> by_log_;
  double clock_sigma_s_ = 0.0;
  bool any_by_clock_ = false;
  std::optional<geo::LocalFrame> frame_;
  std::optional<geo::LatLon> takeoff_;
  PosedFlight posed_;
};

}  // namespace

Result<PosedFlight> EstimatePoses(const flight::Flight& flight, const EstimatePosesOptions& options,
                                  Progress& /*progress*/) {
  return Estimation(flight, options).Run();
}

}  // namespace skyquilt::poses
