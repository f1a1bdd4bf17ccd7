#include "core/poses/photo_rows.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <map>

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
    use.warnings.push_back(fmt::format(
        "{} is not used: its rows name {} photos (the first is {}), and none of the photos given is called so.",
        log.file_name, rows.size(), rows.begin()->first));
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

}  // namespace skyquilt::poses
