#include "core/poses/evidence/smoother_input.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/flight/logs/log_builder.h"
#include "core/poses/conventions/attitude_convention.h"
#include "core/poses/log_span.h"
#include "core/poses/smoother/chain_factors.h"
#include "core/poses/so3.h"

namespace skyquilt::poses {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// A steady climb and a calm hover feel like rest to inertial sensors; only rest on the ground, by the
// barometer, is rest.
bool IsAloft(const std::vector<HeightFix>& heights, const StillInterval& interval) {
  constexpr double kGroundM = 2.5;   // the barometer's drift over a flight and its noise
  constexpr double kAroundS = 60.0;  // take-off and landing may lie at different heights
  double ground = 1e9;
  for (const HeightFix& h : heights) {
    if (h.t_s > interval.begin_s - kAroundS && h.t_s < interval.end_s + kAroundS) {
      ground = std::min(ground, h.z_in_enu_m);
    }
  }
  return std::any_of(heights.begin(), heights.end(), [&](const HeightFix& h) {
    return h.t_s >= interval.begin_s && h.t_s <= interval.end_s && h.z_in_enu_m > ground + kGroundM;
  });
}

// The part of a rest in which the aircraft also stayed at its height: a slow, even descent onto the ground is
// still flight. The reference is the side away from the flight.
StillInterval AtOneHeight(const std::vector<HeightFix>& heights, StillInterval interval,
                          bool flight_follows) {
  constexpr double kReferenceS = 1.5;
  constexpr double kSameM = 0.5;  // well beyond the barometer's noise
  constexpr double kAwayS = 0.7;  // from the last sign of motion
  double sum = 0.0;
  int count = 0;
  const auto inside = [&](const HeightFix& h) {
    return h.t_s >= interval.begin_s && h.t_s <= interval.end_s;
  };
  for (const HeightFix& h : heights) {
    const double from_edge = flight_follows ? h.t_s - interval.begin_s : interval.end_s - h.t_s;
    if (!inside(h) || from_edge > kReferenceS) continue;
    sum += h.z_in_enu_m;
    ++count;
  }
  StillInterval kept = interval;
  // Settling onto the ground may take seconds that feel like rest.
  if (!flight_follows) kept.begin_s = 0.5 * (interval.begin_s + interval.end_s);
  for (const HeightFix& h : heights) {
    if (count == 0 || !inside(h) || std::abs(h.z_in_enu_m - sum / count) < kSameM) continue;
    if (flight_follows) {
      kept.end_s = std::min(kept.end_s, h.t_s);
    } else {
      kept.begin_s = std::max(kept.begin_s, h.t_s);
    }
  }
  (flight_follows ? kept.end_s : kept.begin_s) += flight_follows ? -kAwayS : kAwayS;
  return kept;
}

// The camera's rotation as a gimbal recorded it at a time, between the two samples around it.
std::optional<Quaterniond> GimbalAt(const std::vector<flight::AttitudeSample>& samples, double t_s) {
  const Around<flight::AttitudeSample> around = AroundTime(samples, t_s);
  if (!around.IsWithin(1.0)) return std::nullopt;
  const Quaterniond ned_from_gimbal =
      around.before->ned_from_body.slerp(around.weight, around.after->ned_from_body);
  return (EnuFromNed() * ned_from_gimbal * CamFromGimbal().conjugate()).normalized();
}

class Preparation {
 public:
  Preparation(const FlightSources& sources, const geo::LocalFrame& frame) : from_(sources), frame_(frame) {}

  PreparedSmoothing Make() {
    for (const PhotoAtTime& p : from_.photos) {
      out_.input.photo_times_s.push_back(p.t_s);
      out_.time_sigma_s.push_back(p.sigma_s);
    }
    SmootherOptions& o = out_.input.options;
    o.gravity_mps2 = NormalGravityMps2(frame_.origin().lat_deg, frame_.origin().height_ellipsoid_m);
    TakeImu();
    TakePositions();
    TakeHeights();
    const bool has_airframe = !out_.input.imu.empty() || (from_.log && !from_.log->attitude.empty());
    if (has_airframe) {
      BodyIsAirframe();
    } else {
      BodyIsCamera();
    }
    if (!out_.is_placed) {
      StartWithoutPositions();
      // An autopilot without positions takes the felt vertical for the true one and leans with every drag and
      // acceleration: its tilt is far worse than the inertial sums from a start at rest.
      if (!out_.input.imu.empty()) o.attitude_bias_sigma_rad.head<2>().setConstant(0.035);
    }
    if (from_.log) o.tau_camera_sigma_s = from_.photo_clock_sigma_s;
    return std::move(out_);
  }

 private:
  void Note(std::string text) { out_.notes.push_back(std::move(text)); }

  void TakeImu() {
    if (!from_.log || from_.log->imu.empty()) return;
    const std::optional<ImuNoise> noise = JudgeImu(from_.log->imu);
    if (!noise) {
      Note("inertial samples are too few or too slow to be integrated");
      return;
    }
    out_.input.imu = from_.log->imu;
    out_.input.options.imu = *noise;
    Note("inertial samples of the log");
  }

  void TakePositions() {
    GnssSeries gnss;
    SmootherOptions& o = out_.input.options;
    if (from_.log && !from_.log->gnss.empty()) {
      gnss = GnssOfLog(from_.log->gnss, frame_);
      Note(gnss.is_rtk ? "RTK positions of the log" : "GNSS positions of the log");
      if (!out_.input.imu.empty()) {
        o.tau_gnss_sigma_s = 0.15;
        if (gnss.is_rtk) o.lever_gnss_sigma_m = 0.2;
      }
    } else {
      gnss = GnssOfPhotos(from_.photos, frame_);
      if (!gnss.positions.empty())
        Note(gnss.is_rtk ? "RTK positions of the photos" : "GNSS positions of the photos");
    }
    o.gnss_bias_sigma_m = gnss.bias_sigma_m;
    out_.is_placed = !gnss.positions.empty();
    out_.input.positions = std::move(gnss.positions);
    out_.input.velocities = std::move(gnss.velocities);
  }

  void TakeHeights() {
    SmootherOptions& o = out_.input.options;
    if (from_.log && !from_.log->baro.empty()) {
      out_.input.heights = HeightsOfLog(from_.log->baro);
      Note("barometric heights of the log");
    } else {
      for (const PhotoAtTime& p : from_.photos) {
        if (p.height_above_ground_m) out_.input.heights.push_back({p.t_s, *p.height_above_ground_m, 0.15});
      }
      // The barometer has drifted since take-off.
      constexpr double kZeroSigmaM = 0.1;
      o.baro_bias_first_sigma_m = std::hypot(kZeroSigmaM, o.baro_bias_walk * std::sqrt(60.0));
      if (!out_.input.heights.empty()) Note("heights of the photos");
    }
    // Ground under the range finder is the take-off plane only where there is nothing better to say so.
    if (from_.log && !from_.log->range.empty() && (!out_.is_placed || out_.input.heights.empty())) {
      out_.input.ranges = RangesOfLog(from_.log->range);
      Note("range finder above flat ground");
    }
  }

  void BodyIsAirframe() {
    SmootherOptions& o = out_.input.options;
    out_.input.attitudes = AttitudesOfLog(from_.log->attitude);
    const bool has_yaw = std::any_of(out_.input.attitudes.begin(), out_.input.attitudes.end(),
                                     [](const AttitudeFix& a) { return a.has_yaw; });
    if (!out_.input.attitudes.empty()) Note("attitude of the log");
    if (!has_yaw && out_.input.imu.empty()) AssumeCourse();
    bool any_gimbal = false;
    for (const PhotoAtTime& p : from_.photos) {
      std::optional<Quaterniond> recorded;
      if (p.photo->attitude && p.photo->attitude->kind == flight::AttitudeKind::kGimbal) {
        recorded = CamFromEnu(*p.photo->attitude).conjugate();
      } else {
        recorded = GimbalAt(from_.log->gimbal, p.t_s);
      }
      any_gimbal = any_gimbal || recorded.has_value();
      out_.recorded_enu_from_cam.push_back(recorded);
      out_.cam_from_body.push_back(CamFromBody());
      out_.attitude_origins.push_back(AttitudeOrigin::kSmoothed);
    }
    o.boresight_sigma_rad = any_gimbal ? 0.0087 : 0.052;
    Note(any_gimbal ? "camera angles of the gimbal" : "camera fixed to the airframe, looking down");
  }

  void BodyIsCamera() {
    bool any = false;
    for (const PhotoAtTime& p : from_.photos) {
      out_.recorded_enu_from_cam.emplace_back();
      if (!p.photo->attitude) {
        out_.cam_from_body.push_back(CamFromBody());
        out_.attitude_origins.push_back(AttitudeOrigin::kCourse);
        continue;
      }
      any = true;
      const Quaterniond cam_from_enu = CamFromEnu(*p.photo->attitude);
      // A level body under the camera: the slow error's yaw part is then about the vertical.
      const double yaw_rad = AnglesOf(cam_from_enu).yaw_rad;
      const Quaterniond enu_from_body = EnuFromNed() * flight::NedFromYawPitchRoll(yaw_rad, 0.0, 0.0);
      out_.cam_from_body.push_back((cam_from_enu * enu_from_body).normalized());
      out_.attitude_origins.push_back(AttitudeOrigin::kRecorded);
      out_.input.attitudes.push_back({p.t_s, enu_from_body.normalized(), 0.0017, true});
    }
    if (any) {
      Note("camera angles of the photos");
    } else {
      AssumeCourse();
    }
  }

  void AssumeCourse() {
    SmootherOptions& o = out_.input.options;
    o.assume_level = out_.input.attitudes.empty();
    o.yaw_from_course = true;
    if (o.assume_level) {
      o.attitude_bias_sigma_rad = Vector3d(0.09, 0.09, 0.26);  // 5, 5, 15 deg
      o.attitude_bias_time_s = 5.0;
    } else {
      o.attitude_bias_sigma_rad.z() = 0.26;
    }
    Note("yaw from the course over ground");
  }

  void StartWithoutPositions() {
    std::vector<StillInterval> still = FindStillness(out_.input.imu);
    std::erase_if(still, [&](const StillInterval& s) { return IsAloft(out_.input.heights, s); });
    Marker start;
    start.position_in_enu_m = from_.start_in_enu_m;
    const double first_photo = from_.photos.empty() ? 0.0 : from_.photos.front().t_s;
    const double last_photo = from_.photos.empty() ? 0.0 : from_.photos.back().t_s;
    // The last rest before the photos and the first after them: what was flown before is another flight.
    const auto after_first = std::find_if(still.begin(), still.end(),
                                          [&](const StillInterval& s) { return s.begin_s >= first_photo; });
    const auto after_last = std::find_if(still.begin(), still.end(),
                                         [&](const StillInterval& s) { return s.begin_s > last_photo; });
    if (after_first != still.begin()) {
      start.t_s = (after_first - 1)->begin_s;
      out_.input.still.push_back(AtOneHeight(out_.input.heights, *(after_first - 1), true));
      Note("still on the ground before take-off");
    } else {
      start.t_s = first_photo;
      if (!from_.photos.empty())
        start.position_in_enu_m.z() += from_.photos.front().height_above_ground_m.value_or(0.0);
    }
    out_.input.markers.push_back(start);
    // Wherever it landed, it then stood: its speed is known again, and with it most of what has drifted.
    // Without a barometer a calm hover could pass for that.
    if (after_last != still.end() && (from_.ended_at_start || !from_.log->baro.empty())) {
      out_.input.still.push_back(AtOneHeight(out_.input.heights, *after_last, false));
      Note("still on the ground after landing");
    }
    if (from_.ended_at_start && after_last != still.end()) {
      Marker end = start;
      end.t_s = after_last->end_s;
      end.position_in_enu_m = from_.start_in_enu_m;
      out_.input.markers.push_back(end);
      Note("landed where it took off");
    }
    Note("no positions: dead reckoning from the start point, its drift stated in the error radius");
  }

  const FlightSources& from_;
  const geo::LocalFrame& frame_;
  PreparedSmoothing out_;
};

}  // namespace

PreparedSmoothing MakeSmootherInput(const FlightSources& sources, const geo::LocalFrame& frame) {
  return Preparation(sources, frame).Make();
}

}  // namespace skyquilt::poses
