#include "core/poses/conventions/choose_convention.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <tuple>
#include <utility>

#include "core/base/median.h"
#include "core/geo/lat_lon.h"
#include "core/geo/local_frame.h"
#include "core/poses/conventions/attitude_convention.h"

namespace skyquilt::poses {
namespace {

struct Leg {
  bool is_usable = false;
  double course_rad = 0.0;
};

double AngleBetween(double a_rad, double b_rad) { return std::abs(geo::WrapRad(a_rad - b_rad)); }

}  // namespace

std::vector<std::optional<double>> CoursesFromPositions(
    const std::vector<Eigen::Vector2d>& positions_in_enu) {
  const std::size_t count = positions_in_enu.size();
  std::vector<std::optional<double>> courses(count);
  if (count < 2) return courses;
  std::vector<Leg> legs(count - 1);
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const Eigen::Vector2d step = positions_in_enu[i + 1] - positions_in_enu[i];
    legs[i] = {step.norm() > 1.0, std::atan2(step.x(), step.y())};
  }
  // How straight the flight runs through the two legs; a lone leg counts as a turn.
  const auto bend = [&](std::size_t a, std::size_t b) {
    if (a >= legs.size() || b >= legs.size() || !legs[a].is_usable || !legs[b].is_usable) return geo::kPi;
    return AngleBetween(legs[a].course_rad, legs[b].course_rad);
  };
  constexpr double kStraightRad = 0.35;
  for (std::size_t i = 0; i < count; ++i) {
    const bool has_before = i > 0 && legs[i - 1].is_usable;
    const bool has_after = i + 1 < count && legs[i].is_usable;
    if (has_before && has_after) {
      const double before_rad = legs[i - 1].course_rad;
      const double turn_rad = geo::WrapRad(legs[i].course_rad - before_rad);
      if (std::abs(turn_rad) < kStraightRad) {
        courses[i] = geo::WrapRad(before_rad + 0.5 * turn_rad);
      } else {
        const bool before_is_straighter = i >= 2 && bend(i - 2, i - 1) <= bend(i, i + 1);
        courses[i] = before_is_straighter ? before_rad : legs[i].course_rad;
      }
    } else if (has_before) {
      courses[i] = legs[i - 1].course_rad;
    } else if (has_after) {
      courses[i] = legs[i].course_rad;
    }
  }
  // Photos taken while hovering share the course of the nearest that moved.
  for (std::size_t i = 1; i < count; ++i) {
    if (!courses[i]) courses[i] = courses[i - 1];
  }
  for (std::size_t i = count - 1; i-- > 0;) {
    if (!courses[i]) courses[i] = courses[i + 1];
  }
  return courses;
}

std::vector<std::optional<double>> CoursesOfCameras(const std::vector<std::string_view>& cameras,
                                                    const std::vector<Eigen::Vector2d>& positions_in_enu) {
  // Steps of one aircraft whose camera changes (a zoom) are not all alike.
  constexpr double kClearlyShorter = 0.8;
  std::vector<std::optional<double>> courses = CoursesFromPositions(positions_in_enu);
  std::map<std::string_view, std::vector<std::size_t>> photos_of;
  for (std::size_t i = 0; i < cameras.size(); ++i) photos_of[cameras[i]].push_back(i);
  for (const auto& [camera, photos] : photos_of) {
    std::vector<Eigen::Vector2d> own;
    std::vector<double> own_steps_m, steps_m;
    for (const std::size_t i : photos) {
      const Eigen::Vector2d& at = positions_in_enu[i];
      if (!own.empty()) own_steps_m.push_back((at - own.back()).norm());
      if (i > 0) steps_m.push_back((at - positions_in_enu[i - 1]).norm());
      own.push_back(at);
    }
    const auto own_step_m = MedianIfAny(std::move(own_steps_m)), step_m = MedianIfAny(std::move(steps_m));
    if (!own_step_m || !step_m || *own_step_m >= kClearlyShorter * *step_m) continue;
    const auto own_courses = CoursesFromPositions(own);
    for (std::size_t k = 0; k < photos.size(); ++k) {
      if (own_courses[k]) courses[photos[k]] = own_courses[k];
    }
  }
  return courses;
}

namespace {

using flight::AttitudeKind;
using flight::Photo;
using flight::RecordedAttitude;

struct Reading {
  std::string_view name;
  AttitudeKind kind;
  double pitch_sign = 1.0, pitch_zero_rad = 0.0;

  RecordedAttitude Of(RecordedAttitude recorded) const {
    recorded.kind = kind;
    recorded.pitch_rad = pitch_sign * recorded.pitch_rad + pitch_zero_rad;
    return recorded;
  }
};

std::vector<Reading> ReadingsOf(AttitudeKind kind) {
  if (kind == AttitudeKind::kAirframe)
    return {{"as recorded", kind}, {"as the camera's own", AttitudeKind::kGimbal}};
  return {{"as recorded", kind},
          {"as the airframe's", AttitudeKind::kAirframe},
          {"with pitch from nadir", kind, 1.0, -0.5 * geo::kPi},
          {"with pitch down positive", kind, -1.0}};
}

// What the photos' positions and heights say, in metres about the first.
struct Place {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  double height_m = 0.0;
  double footprint_m = 0.0;
};

std::vector<std::optional<Place>> PlacesOf(const std::vector<Photo>& photos) {
  std::vector<std::optional<Place>> places(photos.size());
  std::optional<geo::LocalFrame> frame;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!photos[i].position) continue;
    const flight::RecordedPosition& p = *photos[i].position;
    const geo::Wgs84 here{p.position.lat_deg, p.position.lon_deg, 0.0};
    if (!frame) frame.emplace(here);
    Place place;
    place.at = frame->EnuFromWgs84(here).head<2>();
    place.height_m = p.height_above_ground_m.value_or(p.height_above_takeoff_m.value_or(60.0));
    const camera::Intrinsics& lens = photos[i].intrinsics;
    place.footprint_m = place.height_m * std::max(lens.width_px, lens.height_px) / lens.MeanFocalPx();
    places[i] = place;
  }
  return places;
}

// Under which names angles were recorded, and by whom: one convention holds for all of a group.
using AngleNames = std::tuple<AttitudeKind, std::string, std::string>;
using Members = std::vector<std::size_t>;  // places in the order of capture

std::map<AngleNames, Members> GroupsOf(const std::vector<Photo>& photos) {
  std::map<AngleNames, Members> groups;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!photos[i].attitude) continue;
    groups[{photos[i].attitude->kind, photos[i].attitude->source, photos[i].make}].push_back(i);
  }
  return groups;
}

// 1: every photo looks at the ground below the flight and shares it with the next; 0: none does.
double Score(const std::vector<Photo>& photos, const std::vector<std::optional<Place>>& places,
             const Members& members, const Reading& reading) {
  int seen = 0, shared = 0, pairs = 0;
  std::optional<std::pair<Eigen::Vector2d, double>> before;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const std::size_t i = members[k];
    const Eigen::Vector3d axis =
        CamFromEnu(reading.Of(*photos[i].attitude)).conjugate() * Eigen::Vector3d::UnitZ();
    const bool looks_down = axis.z() < -0.35;  // 20 degrees below the horizon
    seen += looks_down ? 1 : 0;
    std::optional<std::pair<Eigen::Vector2d, double>> here;
    if (looks_down && places[i]) {
      here = {places[i]->at - places[i]->height_m / axis.z() * axis.head<2>(), places[i]->footprint_m};
    }
    // Photos between which others were taken need not share anything.
    const bool follows = k > 0 && members[k - 1] + 1 == i && places[i] && places[i - 1];
    pairs += follows ? 1 : 0;
    if (follows && here && before && (here->first - before->first).norm() < here->second) ++shared;
    before = here;
  }
  const double by_ground = static_cast<double>(seen) / static_cast<double>(members.size());
  return pairs == 0 ? by_ground : 0.5 * by_ground + 0.5 * shared / pairs;
}

// The reading of one group, which is put into its photos.
ConventionChoice ChooseOfGroup(const std::vector<std::optional<Place>>& places, const AngleNames& names,
                               const Members& members, std::vector<Photo>& photos) {
  const AttitudeKind kind = std::get<AttitudeKind>(names);
  const std::vector<Reading> readings = ReadingsOf(kind);
  std::vector<double> scores;
  scores.reserve(readings.size());
  for (const Reading& reading : readings) scores.push_back(Score(photos, places, members, reading));
  const auto best = static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
  // A panorama of few photos may well look at the horizon.
  constexpr std::size_t kFewPhotos = 5;
  ConventionChoice choice;
  choice.is_changed = best != 0 && members.size() >= kFewPhotos && scores[0] < 0.3 && scores[best] > 0.8;
  const Reading& taken = readings[choice.is_changed ? best : 0];
  choice.words =
      fmt::format("{} angles of {} read {} (fit", kind == AttitudeKind::kGimbal ? "camera" : "airframe",
                  photos[members.front()].attitude->source, taken.name);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    choice.words += fmt::format("{} {} {:.2f}", i == 0 ? "" : ",", readings[i].name, scores[i]);
  }
  choice.words += ")";
  if (choice.is_changed) {
    for (const std::size_t i : members) photos[i].attitude = taken.Of(*photos[i].attitude);
  }
  return choice;
}

// "heading minus course -1 deg (half within 2)" for photos that move.
std::string Difference(std::string_view what, const std::vector<double>& differences_rad) {
  if (differences_rad.size() < 3) return "";
  double east = 0.0, north = 0.0;
  for (const double d : differences_rad) {
    east += std::sin(d);
    north += std::cos(d);
  }
  const double mean = std::atan2(east, north);
  std::vector<double> apart;
  apart.reserve(differences_rad.size());
  for (const double d : differences_rad) apart.push_back(std::abs(geo::WrapRad(d - mean)));
  return fmt::format("; heading minus {} {:+.0f} deg, half of {} photos within {:.0f} deg of that", what,
                     geo::RadToDeg(mean), differences_rad.size(), geo::RadToDeg(Median(std::move(apart))));
}

double CameraHeadingOf(const RecordedAttitude& attitude) { return AnglesOf(CamFromEnu(attitude)).yaw_rad; }

}  // namespace

ConventionChoice ChooseConvention(std::vector<Photo>& photos,
                                  const std::vector<std::optional<double>>& airframe_yaw_rad) {
  ConventionChoice choice;
  const std::map<AngleNames, Members> groups = GroupsOf(photos);
  if (groups.empty()) return choice;
  const std::vector<std::optional<Place>> places = PlacesOf(photos);
  // Said of a fleet is what was changed, of three makers at most, else how most photos are read.
  constexpr int kMaxNamed = 3;
  int named = 0;
  std::size_t most = 0;
  std::string words_of_most;
  for (const auto& [names, members] : groups) {
    ConventionChoice one = ChooseOfGroup(places, names, members, photos);
    if (members.size() > most) {
      most = members.size();
      words_of_most = one.words;
    }
    if (!one.is_changed) continue;
    choice.is_changed = true;
    if (++named <= kMaxNamed) choice.words += (named > 1 ? "; " : "") + one.words;
  }
  if (!choice.is_changed) choice.words = words_of_most;

  std::vector<Eigen::Vector2d> track;
  std::vector<const Photo*> on_track;
  std::vector<std::string_view> cameras;
  std::vector<double> against_airframe;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!photos[i].attitude) continue;
    if (i < airframe_yaw_rad.size() && airframe_yaw_rad[i]) {
      against_airframe.push_back(geo::WrapRad(CameraHeadingOf(*photos[i].attitude) - *airframe_yaw_rad[i]));
    }
    if (!places[i]) continue;
    track.push_back(places[i]->at);
    on_track.push_back(&photos[i]);
    cameras.emplace_back(photos[i].camera_key);
  }
  const auto courses = CoursesOfCameras(cameras, track);
  std::vector<double> against_course;
  for (std::size_t k = 0; k < courses.size(); ++k) {
    if (courses[k])
      against_course.push_back(geo::WrapRad(CameraHeadingOf(*on_track[k]->attitude) - *courses[k]));
  }
  choice.words += Difference("course", against_course) + Difference("the log's airframe", against_airframe);
  return choice;
}

}  // namespace skyquilt::poses
