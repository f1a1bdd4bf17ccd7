#include "core/poses/photo_rows.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/median.h"
#include "core/base/text/printable.h"
#include "core/flight/logs/texts/list_rows.h"
#include "core/geo/geodesic.h"
#include "core/geo/geoid.h"
#include "core/poses/conventions/attitude_convention.h"
#include "core/poses/evidence/common_error.h"
#include "core/poses/heights/flight_heights.h"
#include "core/poses/lists/named_photos.h"

namespace skyquilt::poses {
namespace {

using flight::CameraEvent;
using flight::Photo;

// How high above the sea or the ellipsoid.
bool SaysHeights(const flight::FlightLog& log) {
  return std::any_of(log.events.begin(), log.events.end(), [](const CameraEvent& event) {
    return event.height_ellipsoid_m || event.height_amsl_m;
  });
}

// `has_heights`: of the list; from two sources in one list they would count from two zeros.
void TakePosition(const CameraEvent& event, const std::string& source, bool has_heights, Photo& photo) {
  flight::RecordedPosition position;
  position.position = *event.position;
  static_cast<flight::RecordedHeights&>(position) = event;
  // The heights that only the photo knows stay: they do not contradict a better position.
  if (!position.height_above_takeoff_m) {
    position.height_above_takeoff_m =
        photo.position ? photo.position->height_above_takeoff_m : photo.lone_height_above_takeoff_m;
  }
  if (photo.position && !position.height_above_ground_m)
    position.height_above_ground_m = photo.position->height_above_ground_m;
  if (photo.position && !has_heights) {
    const flight::RecordedPosition& own = *photo.position;
    static_cast<flight::GnssHeights&>(position) = own;
    // Beside a corrected place a receiver's would pass for surveyed; one above the sea does not.
    if (IsCorrected(event) && !own.is_rtk_fixed && own.height_ellipsoid_m) {
      if (!own.height_amsl_m)
        position.height_amsl_m = *own.height_ellipsoid_m - geo::GeoidHeightM(own.position).value_or(0.0);
      position.height_ellipsoid_m.reset();
    }
  }
  if (event.sigma_in_ned_m) {
    position.sigma_horizontal_m = event.sigma_in_ned_m->head<2>().norm() / std::sqrt(2.0);
    position.sigma_vertical_m = event.sigma_in_ned_m->z();
  }
  position.is_rtk_fixed = IsCorrected(event);
  // Surveyed heights count from the ellipsoid, whatever the list has them from.
  if (position.is_rtk_fixed && event.height_amsl_m) position.height_ellipsoid_m = EllipsoidHeightM(position);
  position.system_error_m = event.system_error_m;
  position.source = source;
  photo.position = position;
}

flight::RecordedAttitude AnglesOfEvent(const CameraEvent& event, const std::string& source) {
  const Eigen::Vector3d& angles = *event.yaw_pitch_roll_rad;
  return {event.attitude_kind, angles.x(), angles.y(), angles.z(), source};
}

// What the camera says of itself is not given up for what may be the airframe's.
bool MayTakeAngles(const CameraEvent& event, const Photo& photo) {
  return !photo.attitude || photo.attitude->kind != flight::AttitudeKind::kGimbal ||
         event.attitude_kind == flight::AttitudeKind::kGimbal;
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
  event.position = geo::OnTheWay(a, b, share);
  event.height_ellipsoid_m = Between(from.height_ellipsoid_m, to.height_ellipsoid_m, share);
  event.height_amsl_m = Between(from.height_amsl_m, to.height_amsl_m, share);
  event.height_above_takeoff_m = Between(from.height_above_takeoff_m, to.height_above_takeoff_m, share);
  const double way_m = geo::MetresApart(a, b);
  const double off_m = std::hypot(kOffStraight * 4.0 * share * (1.0 - share), sigma_share) * way_m;
  const Eigen::Vector3d unknown = Eigen::Vector3d::Constant(kUnknownSigmaM);
  const Eigen::Vector3d worse =
      from.sigma_in_ned_m.value_or(unknown).cwiseMax(to.sigma_in_ned_m.value_or(unknown));
  event.sigma_in_ned_m = worse + Eigen::Vector3d::Constant(off_m);
  event.system_error_m = from.system_error_m;
  return event;
}

// `apart_rad`: by photo, the list's angles from the camera's own.
void SayWhoseAngles(const std::string& list, std::vector<double> apart_rad, PhotoRowsUse& use) {
  constexpr double kContradictDeg = 8.0;  // more than a gimbal, its compass and the rounding of a list err by
  const std::size_t count = apart_rad.size();
  const double apart_deg = Median(std::move(apart_rad)) * (180.0 / geo::kPi);
  std::string& line = use.lines.back();
  line +=
      fmt::format("; {} keep{} the angles of {} own gimbal, {:.1f} degrees from the list's",
                  Counted(count, "photo"), count == 1 ? "s" : "", count == 1 ? "its" : "their", apart_deg);
  if (apart_deg < kContradictDeg) return;
  use.warnings.push_back({flight::RemarkCode::kListAnglesContradict,
                          {{"file", list}, {"apart_deg", apart_deg}, {"photos", count}}});
}

std::optional<double> RecordedHeightM(const Photo& photo) {
  return photo.position ? EllipsoidHeightM(*photo.position) : std::nullopt;
}

std::optional<double> AboveTakeoffM(const Photo& photo) {
  constexpr double kFilledM = 1.0;  // less is a field that is never filled
  const auto& height_m =
      photo.position ? photo.position->height_above_takeoff_m : photo.lone_height_above_takeoff_m;
  return height_m && *height_m > kFilledM ? height_m : std::nullopt;
}

constexpr double kContradictM = 100.0;  // more than a barometer's zero is off by, or the geoid
constexpr double kTakeoffContradictM = 20.0;

// `higher_m`: by photo, the list's height less the photo's own. Feet, and heights under a name that does not
// say from where they count, lie far away.
void SayOtherHeights(flight::RemarkCode code, const std::string& list, double contradict_m,
                     std::vector<double> higher_m, PhotoRowsUse& use) {
  constexpr std::size_t kFewestPhotos = 3;
  const std::size_t count = higher_m.size();
  if (count < kFewestPhotos) return;
  const double apart_m = std::abs(Median(std::move(higher_m)));
  if (apart_m < contradict_m) return;
  use.warnings.push_back({code, {{"file", list}, {"apart_m", apart_m}, {"photos", count}}});
}

}  // namespace

PhotoRowsUse ApplyPhotoRows(const std::vector<flight::FlightLog>& logs, std::vector<Photo>& photos) {
  PhotoRowsUse use;
  const NamedPhotos named(photos);
  for (const flight::FlightLog& log : logs) {
    std::size_t rows = 0, open_rows = 0;
    std::string first_name, first_open;
    // By photo. The first row holds, of those that kept what they say (lists/choose_rows.h).
    std::vector<char> is_named(photos.size(), 0), is_placed(photos.size(), 0), is_turned(photos.size(), 0);
    bool names_files = false;  // with the ending of one; surveyed points have none
    std::vector<double> angles_apart_rad, higher_m, higher_above_takeoff_m;  // where both know them
    const std::vector<NamedPhotos::Found> found_by_event = named.FindAll(log);
    const bool has_heights = SaysHeights(log);
    for (std::size_t k = 0; k < log.events.size(); ++k) {
      const CameraEvent& event = log.events[k];
      if (event.has_time || !event.image_name) continue;
      if (rows++ == 0) first_name = *event.image_name;
      names_files = names_files || flight::LooksLikeImageName(*event.image_name);
      const NamedPhotos::Found& found = found_by_event[k];
      if (found.is_open && open_rows++ == 0) first_open = *event.image_name;
      for (const std::size_t i : found.photos) {
        is_named[i] = 1;
        Photo& photo = photos[i];
        if (event.position && !std::exchange(is_placed[i], 1)) {
          const auto own_m = RecordedHeightM(photo), own_above_takeoff_m = AboveTakeoffM(photo);
          TakePosition(event, log.file_name, has_heights, photo);
          if (const auto taken_m = RecordedHeightM(photo); own_m && taken_m)
            higher_m.push_back(*taken_m - *own_m);
          if (own_above_takeoff_m && event.height_above_takeoff_m)
            higher_above_takeoff_m.push_back(*event.height_above_takeoff_m - *own_above_takeoff_m);
        }
        if (!event.yaw_pitch_roll_rad || std::exchange(is_turned[i], 1)) continue;
        const flight::RecordedAttitude angles = AnglesOfEvent(event, log.file_name);
        if (MayTakeAngles(event, photo)) {
          photo.attitude = angles;
        } else {
          angles_apart_rad.push_back(CamFromEnu(*photo.attitude).angularDistance(CamFromEnu(angles)));
        }
      }
    }
    if (rows == 0) continue;
    const auto matched = std::count(is_named.begin(), is_named.end(), 1);
    const bool serves = std::count(is_placed.begin(), is_placed.end(), 1) > 0 ||
                        std::count(is_turned.begin(), is_turned.end(), 1) > 0;
    use.lines.push_back(fmt::format("{} ({}) names {} of {} photos{}", log.file_name, log.format, matched,
                                    photos.size(), serves || matched == 0 ? "" : ", and places none"));
    if (!angles_apart_rad.empty()) SayWhoseAngles(log.file_name, std::move(angles_apart_rad), use);
    SayOtherHeights(flight::RemarkCode::kListHeightsContradict, log.file_name, kContradictM,
                    std::move(higher_m), use);
    SayOtherHeights(flight::RemarkCode::kListTakeoffHeightsContradict, log.file_name, kTakeoffContradictM,
                    std::move(higher_above_takeoff_m), use);
    if (open_rows > 0) {
      use.warnings.push_back({flight::RemarkCode::kListRowsOfSeveralPhotos,
                              {{"file", log.file_name}, {"rows", open_rows}, {"first", first_open}}});
    }
    if (matched > 0 || open_rows > 0 || photos.empty()) continue;
    use.warnings.push_back(
        {names_files ? flight::RemarkCode::kListNamesNoPhoto : flight::RemarkCode::kListOfPointsWithoutMarks,
         {{"file", log.file_name}, {"rows", rows}, {"first", first_name}}});
  }
  return use;
}

int ApplyEvents(const flight::FlightLog& log, const TimeSync& sync, bool log_has_track,
                std::vector<Photo>& photos) {
  int placed = 0;
  const bool has_heights = SaysHeights(log);
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!sync.photos[i] || !sync.photos[i]->event) continue;
    const CameraEvent& event = log.events[*sync.photos[i]->event];
    const bool is_wanted = event.is_rtk_fixed || !log_has_track;
    if (event.position && is_wanted) {
      TakePosition(event, log.file_name, has_heights, photos[i]);
      ++placed;
    }
    // With a track the log's own attitude does better than the copy in its camera events.
    const bool lacks_angles = !photos[i].attitude || event.attitude_kind == flight::AttitudeKind::kGimbal;
    if (event.yaw_pitch_roll_rad && lacks_angles &&
        (log.attitude.empty() || event.attitude_kind == flight::AttitudeKind::kGimbal)) {
      photos[i].attitude = AnglesOfEvent(event, log.file_name);
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
                 log.file_name + ", between two rows", true, photos[i]);
    ++placed;
  }
  return placed;
}

}  // namespace skyquilt::poses
