#include "core/poses/photo_rows.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/median.h"
#include "core/geo/geodesic.h"
#include "core/poses/heights/flight_heights.h"

namespace skyquilt::poses {
namespace {

using flight::CameraEvent;
using flight::Photo;

void TakePosition(const CameraEvent& event, const std::string& source, Photo& photo) {
  flight::RecordedPosition position;
  position.position = *event.position;
  position.height_ellipsoid_m = event.height_ellipsoid_m;
  position.height_amsl_m = event.height_amsl_m;
  position.height_above_takeoff_m = event.height_above_takeoff_m;
  position.height_above_ground_m = event.height_above_ground_m;
  if (photo.position) {
    // The heights that only the photo knows stay: they do not contradict a better position.
    if (!position.height_above_takeoff_m)
      position.height_above_takeoff_m = photo.position->height_above_takeoff_m;
    if (!position.height_above_ground_m)
      position.height_above_ground_m = photo.position->height_above_ground_m;
  }
  if (event.sigma_in_ned_m) {
    position.sigma_horizontal_m = event.sigma_in_ned_m->head<2>().norm() / std::sqrt(2.0);
    position.sigma_vertical_m = event.sigma_in_ned_m->z();
  }
  position.is_rtk_fixed = event.is_rtk_fixed;
  position.source = source;
  photo.position = position;
}

void TakeAngles(const CameraEvent& event, const std::string& source, Photo& photo) {
  const Eigen::Vector3d& angles = *event.yaw_pitch_roll_rad;
  photo.attitude = flight::RecordedAttitude{event.attitude_kind, angles.x(), angles.y(), angles.z(), source};
}

std::optional<double> Between(const std::optional<double>& from, const std::optional<double>& to,
                              double share) {
  if (!from || !to) return std::nullopt;
  return *from + share * (*to - *from);
}

// `share` of the way, known to `sigma_share` of it. An aircraft keeps to the straight way within a fifth.
CameraEvent Between(const CameraEvent& from, const CameraEvent& to, double share, double sigma_share) {
  constexpr double kOffStraight = 0.2, kUnknownSigmaM = 3.0;
  CameraEvent event;
  const geo::LatLon &a = *from.position, &b = *to.position;
  const double lon_deg = a.lon_deg + share * std::remainder(b.lon_deg - a.lon_deg, 360.0);
  event.position = geo::LatLon{a.lat_deg + share * (b.lat_deg - a.lat_deg), std::remainder(lon_deg, 360.0)};
  event.height_ellipsoid_m = Between(from.height_ellipsoid_m, to.height_ellipsoid_m, share);
  event.height_amsl_m = Between(from.height_amsl_m, to.height_amsl_m, share);
  event.height_above_takeoff_m = Between(from.height_above_takeoff_m, to.height_above_takeoff_m, share);
  const double way_m = geo::MetresApart(a, b);
  const double off_m = std::hypot(kOffStraight * 4.0 * share * (1.0 - share), sigma_share) * way_m;
  const Eigen::Vector3d unknown = Eigen::Vector3d::Constant(kUnknownSigmaM);
  const Eigen::Vector3d worse =
      from.sigma_in_ned_m.value_or(unknown).cwiseMax(to.sigma_in_ned_m.value_or(unknown));
  event.sigma_in_ned_m = worse + Eigen::Vector3d::Constant(off_m);
  return event;
}

}  // namespace

std::string PlainPhotoName(const std::string& name) {
  std::string plain = name.substr(name.find_last_of("/\\") + 1);
  std::transform(plain.begin(), plain.end(), plain.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return plain;
}

PhotoRowsUse ApplyPhotoRows(const std::vector<flight::FlightLog>& logs, std::vector<Photo>& photos) {
  PhotoRowsUse use;
  for (const flight::FlightLog& log : logs) {
    std::map<std::string, const CameraEvent*> rows;
    for (const CameraEvent& event : log.events) {
      if (!event.has_time && event.image_name) rows.emplace(PlainPhotoName(*event.image_name), &event);
    }
    if (rows.empty()) continue;
    int matched = 0;
    for (Photo& photo : photos) {
      const std::string name = PlainPhotoName(photo.name);
      auto row = rows.find(name);
      if (row == rows.end()) row = rows.find(name.substr(0, name.rfind('.')));  // lists without endings
      if (row == rows.end()) continue;
      ++matched;
      if (row->second->position) TakePosition(*row->second, log.file_name, photo);
      if (row->second->yaw_pitch_roll_rad) TakeAngles(*row->second, log.file_name, photo);
    }
    use.lines.push_back(
        fmt::format("{} ({}) names {} of {} photos", log.file_name, log.format, matched, photos.size()));
    if (matched > 0 || photos.empty()) continue;
    use.warnings.push_back(
        {flight::RemarkCode::kListNamesNoPhoto,
         {{"file", log.file_name}, {"rows", rows.size()}, {"first", rows.begin()->first}}});
  }
  return use;
}

int ApplyEvents(const flight::FlightLog& log, const TimeSync& sync, bool log_has_track,
                std::vector<Photo>& photos) {
  int placed = 0;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!sync.photos[i] || !sync.photos[i]->event) continue;
    const CameraEvent& event = log.events[*sync.photos[i]->event];
    const bool is_wanted = event.is_rtk_fixed || !log_has_track;
    if (event.position && is_wanted) {
      TakePosition(event, log.file_name, photos[i]);
      ++placed;
    }
    // With a track the log's own attitude does better than the copy in its camera events.
    const bool lacks_angles = !photos[i].attitude || event.attitude_kind == flight::AttitudeKind::kGimbal;
    if (event.yaw_pitch_roll_rad && lacks_angles &&
        (log.attitude.empty() || event.attitude_kind == flight::AttitudeKind::kGimbal)) {
      TakeAngles(event, log.file_name, photos[i]);
    }
  }
  return placed;
}

int PlaceBetweenEvents(const flight::FlightLog& log, const TimeSync& sync, std::vector<Photo>& photos) {
  std::vector<const CameraEvent*> rows;
  std::vector<double> intervals_s;
  for (const CameraEvent& event : log.events) {
    if (!event.has_time || !event.position) continue;
    if (!rows.empty()) intervals_s.push_back(event.t_s - rows.back()->t_s);
    rows.push_back(&event);
  }
  if (intervals_s.empty()) return 0;
  constexpr double kLongestInIntervals = 5.0;
  const double longest_s = kLongestInIntervals * Median(std::move(intervals_s));
  int placed = 0;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (photos[i].position || !sync.photos[i]) continue;
    const auto& [t_s, sigma_s, own_event] = *sync.photos[i];
    const auto after = std::lower_bound(rows.begin(), rows.end(), t_s,
                                        [](const CameraEvent* row, double at_s) { return row->t_s < at_s; });
    if (after == rows.begin() || after == rows.end()) continue;
    const CameraEvent &from = **(after - 1), &to = **after;
    const double interval_s = to.t_s - from.t_s;
    if (!(interval_s > 0.0) || interval_s > longest_s) continue;
    TakePosition(Between(from, to, (t_s - from.t_s) / interval_s, sigma_s / interval_s),
                 log.file_name + ", between two rows", photos[i]);
    ++placed;
  }
  return placed;
}

}  // namespace skyquilt::poses
