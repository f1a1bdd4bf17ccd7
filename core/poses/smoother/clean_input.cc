#include "core/poses/smoother/clean_input.h"

#include <algorithm>
#include <cmath>

#include "core/flight/remarks/because.h"
#include "core/poses/log_span.h"

namespace skyquilt::poses {
namespace {

bool IsGood(const flight::ImuSample& s) {
  return s.angular_rate_radps.allFinite() && s.specific_force_mps2.allFinite();
}
bool IsGood(const PositionFix& f) {
  return f.position_in_enu_m.allFinite() && f.sigma_m.allFinite() && f.sigma_m.minCoeff() > 0.0;
}
bool IsGood(const VelocityFix& f) {
  return f.velocity_in_enu_mps.allFinite() && f.sigma_mps.allFinite() && f.sigma_mps.minCoeff() > 0.0;
}
bool IsGood(const AttitudeFix& f) {
  return f.enu_from_body.coeffs().allFinite() && std::abs(f.enu_from_body.norm() - 1.0) < 1e-3 &&
         std::isfinite(f.sigma_rad) && f.sigma_rad > 0.0;
}
bool IsGood(const HeightFix& f) {
  return std::isfinite(f.z_in_enu_m) && std::isfinite(f.sigma_m) && f.sigma_m > 0.0;
}
bool IsGood(const RangeFix& f) { return std::isfinite(f.distance_m) && f.distance_m > 0.0; }
bool IsGood(const Marker& m) {
  return m.position_in_enu_m.allFinite() && std::isfinite(m.sigma_m) && m.sigma_m > 0.0 &&
         (!m.yaw_rad || (std::isfinite(*m.yaw_rad) && m.sigma_yaw_rad > 0.0));
}

// Keeps what is finite and later than all kept before it. Times that run back for one sample lose that
// sample; `may_repeat` is for markers.
template <typename Fix>
void Clean(const char* name, bool may_repeat, std::vector<Fix>& fixes, std::vector<std::string>& warnings) {
  std::vector<Fix> kept;
  kept.reserve(fixes.size());
  for (const Fix& f : fixes) {
    if (!std::isfinite(f.t_s) || !IsGood(f)) continue;
    if (!kept.empty() && !(may_repeat ? f.t_s >= kept.back().t_s : f.t_s > kept.back().t_s)) continue;
    kept.push_back(f);
  }
  if (kept.size() < fixes.size()) {
    warnings.push_back(std::to_string(fixes.size() - kept.size()) + " of " + std::to_string(fixes.size()) +
                       " " + name + " samples were left out: not finite, repeated or out of order.");
  }
  fixes = std::move(kept);
}

template <typename Fix>
void Cut(double begin, double end, std::vector<Fix>& fixes) {
  std::erase_if(fixes, [&](const Fix& f) { return f.t_s < begin || f.t_s > end; });
}

constexpr double kMarginS = 30.0;       // measurements this long before and after the photos still help
constexpr double kRestMarginS = 120.0;  // stillness fixes the speed and the biases from further off

}  // namespace

Result<CleanInput> CleanSmootherInput(const SmootherInput& raw) {
  CleanInput clean;
  clean.input = raw;
  SmootherInput& in = clean.input;
  if (in.photo_times_s.empty())
    return Error{ErrorCode::kUnprocessable, "There are no photos to find poses for.", ""};
  for (std::size_t k = 0; k < in.photo_times_s.size(); ++k) {
    if (!std::isfinite(in.photo_times_s[k]) || (k > 0 && in.photo_times_s[k] < in.photo_times_s[k - 1])) {
      return Error{ErrorCode::kUnprocessable, "The times of the photos are not known or not in order.",
                   "photo " + std::to_string(k)};
    }
  }
  Clean("inertial", false, in.imu, clean.warnings);
  Clean("position", false, in.positions, clean.warnings);
  Clean("velocity", false, in.velocities, clean.warnings);
  Clean("attitude", false, in.attitudes, clean.warnings);
  Clean("height", false, in.heights, clean.warnings);
  Clean("range", false, in.ranges, clean.warnings);
  Clean("marker", true, in.markers, clean.warnings);

  LogSpan asked{in.photo_times_s.front(), in.photo_times_s.back()};
  asked.Take(in.markers);
  for (const StillInterval& s : in.still) {
    // Stillness long before or after the flight, with no marker in it, has nothing to say.
    if (s.end_s < asked.begin_s - kRestMarginS || s.begin_s > asked.end_s + kRestMarginS) continue;
    asked.Take(s.begin_s);
    asked.Take(s.end_s);
  }
  LogSpan known;
  known.Take(in.imu);
  known.Take(in.positions);
  known.Take(in.velocities);
  known.Take(in.attitudes);
  known.Take(in.heights);
  clean.begin_s = std::min(asked.begin_s, std::max(known.begin_s, asked.begin_s - kMarginS));
  clean.end_s = std::max(asked.end_s, std::min(known.end_s, asked.end_s + kMarginS));
  Cut(clean.begin_s - 1.0, clean.end_s + 1.0, in.imu);
  Cut(clean.begin_s, clean.end_s, in.positions);
  Cut(clean.begin_s, clean.end_s, in.velocities);
  Cut(clean.begin_s, clean.end_s, in.attitudes);
  Cut(clean.begin_s, clean.end_s, in.heights);
  Cut(clean.begin_s, clean.end_s, in.ranges);

  if (in.positions.empty() && in.markers.empty()) {
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kNothingToStartFrom);
  }
  return clean;
}

std::vector<AttitudeFix> AttitudesAtKnots(const std::vector<AttitudeFix>& fixes,
                                          const std::vector<double>& knot_times_s) {
  constexpr double kCloseS = 1.2;
  constexpr double kSameTimeS = 1.0e-4;
  constexpr double kAngularAcceleration = 0.5;  // rad/s2, of a usual multirotor manoeuvre
  std::vector<AttitudeFix> at_knots;
  std::size_t knot = 0;
  for (std::size_t k = 0; k < fixes.size(); ++k) {
    const AttitudeFix& a = fixes[k];
    while (knot < knot_times_s.size() && knot_times_s[knot] < a.t_s - kSameTimeS) ++knot;
    const bool on_knot = knot < knot_times_s.size() && knot_times_s[knot] <= a.t_s + kSameTimeS;
    const double before = k > 0 ? a.t_s - fixes[k - 1].t_s : kCloseS;
    const double after = k + 1 < fixes.size() ? fixes[k + 1].t_s - a.t_s : kCloseS;
    if (on_knot || std::min(before, after) >= kCloseS) at_knots.push_back(a);
    if (k + 1 == fixes.size() || after >= kCloseS) continue;
    for (std::size_t i = knot; i < knot_times_s.size() && knot_times_s[i] < fixes[k + 1].t_s - kSameTimeS;
         ++i) {
      if (knot_times_s[i] <= a.t_s + kSameTimeS) continue;
      const double w = (knot_times_s[i] - a.t_s) / after;
      AttitudeFix between = a;
      between.t_s = knot_times_s[i];
      between.enu_from_body = a.enu_from_body.slerp(w, fixes[k + 1].enu_from_body).normalized();
      between.sigma_rad = std::hypot(a.sigma_rad, 0.5 * kAngularAcceleration * after * after * w * (1.0 - w));
      between.has_yaw = a.has_yaw && fixes[k + 1].has_yaw;
      at_knots.push_back(between);
    }
  }
  return at_knots;
}

}  // namespace skyquilt::poses
