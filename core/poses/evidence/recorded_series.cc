#include "core/poses/evidence/recorded_series.h"

#include <algorithm>
#include <cmath>

#include "core/base/median.h"
#include "core/geo/geoid.h"
#include "core/poses/conventions/attitude_convention.h"

namespace skyquilt::poses {
namespace {

using Eigen::Vector3d;

constexpr double kUnknownHeightSigmaM = 30.0;  // a height that says next to nothing
const Vector3d kConsumerWhite(0.15, 0.15, 0.24);
const Vector3d kRtkWhite(0.008, 0.008, 0.012);

// What is common to a series of fixes: the slow error of most of them.
void JudgeSeries(const std::vector<bool>& rtk, const std::vector<double>& sigmas, GnssSeries& series) {
  const auto fixed = std::count(rtk.begin(), rtk.end(), true);
  series.is_rtk = !rtk.empty() && 2 * fixed > static_cast<std::ptrdiff_t>(rtk.size());
  if (series.is_rtk) {
    series.bias_sigma_m = Vector3d(0.01, 0.01, 0.02);
    if (!sigmas.empty()) series.bias_sigma_m *= std::clamp(Median(sigmas) / 0.015, 1.0, 10.0);
  } else if (!sigmas.empty()) {
    series.bias_sigma_m *= std::clamp(Median(sigmas), 0.3, 15.0);
  }
}

Vector3d WhiteSigma(bool series_is_rtk, bool fix_is_rtk, double sigma_horizontal) {
  // Positions written with few digits jump from one grid point to the next.
  constexpr double kCoarseM = 3.0;
  if (!series_is_rtk && sigma_horizontal > kCoarseM) return kConsumerWhite * (sigma_horizontal / 0.15);
  if (!series_is_rtk) return kConsumerWhite;
  // A float or single fix in a fixed flight carries its whole error: the flight's slow one is a fixed fix's.
  return fix_is_rtk ? kRtkWhite : Vector3d(Vector3d(1.0, 1.0, 1.8) * std::max(0.3, sigma_horizontal));
}

}  // namespace

GnssSeries GnssOfLog(const std::vector<flight::GnssSample>& samples, const geo::LocalFrame& frame) {
  GnssSeries series;
  std::vector<bool> rtk;
  std::vector<double> sigmas;
  for (const flight::GnssSample& s : samples) {
    rtk.push_back(s.is_rtk_fixed);
    if (s.sigma_horizontal_m && *s.sigma_horizontal_m > 0.0) sigmas.push_back(*s.sigma_horizontal_m);
  }
  JudgeSeries(rtk, sigmas, series);
  std::optional<double> geoid;  // flat over one flight
  for (const flight::GnssSample& s : samples) {
    PositionFix fix;
    fix.t_s = s.t_s;
    fix.sigma_m = WhiteSigma(series.is_rtk, s.is_rtk_fixed, s.sigma_horizontal_m.value_or(1.5));
    double height = frame.origin().height_ellipsoid_m;
    if (s.height_ellipsoid_m) {
      height = *s.height_ellipsoid_m;
    } else if (s.height_amsl_m) {
      if (!geoid) geoid = geo::GeoidHeightM(s.position).value_or(0.0);
      height = *s.height_amsl_m + *geoid;
    } else {
      fix.sigma_m.z() = kUnknownHeightSigmaM;
    }
    fix.position_in_enu_m = frame.EnuFromWgs84({s.position.lat_deg, s.position.lon_deg, height});
    series.positions.push_back(fix);
    if (!s.velocity_in_ned_mps) continue;
    const Vector3d& v = *s.velocity_in_ned_mps;
    VelocityFix velocity;
    velocity.t_s = s.t_s;
    velocity.velocity_in_enu_mps = Vector3d(v.y(), v.x(), -v.z());
    if (series.is_rtk) velocity.sigma_mps *= 0.5;
    series.velocities.push_back(velocity);
  }
  return series;
}

GnssSeries GnssOfPhotos(const std::vector<PhotoAtTime>& photos, const geo::LocalFrame& frame) {
  GnssSeries series;
  std::vector<bool> rtk;
  std::vector<double> sigmas;
  for (const PhotoAtTime& at : photos) {
    const auto& position = at.photo->position;
    if (!position || position->is_repeated) continue;
    rtk.push_back(position->is_rtk_fixed);
    if (position->sigma_horizontal_m) sigmas.push_back(*position->sigma_horizontal_m);
  }
  JudgeSeries(rtk, sigmas, series);
  for (const PhotoAtTime& at : photos) {
    const flight::Photo* const photo = at.photo;
    if (photo->position && !photo->position->is_repeated) {
      const flight::RecordedPosition& p = *photo->position;
      PositionFix fix;
      fix.t_s = at.t_s;
      fix.sigma_m = WhiteSigma(series.is_rtk, p.is_rtk_fixed, p.sigma_horizontal_m.value_or(1.5));
      // Heights of receivers without RTK are not what they say: the relative one is taken.
      const bool has_height = p.is_rtk_fixed && p.height_ellipsoid_m.has_value();
      if (!has_height) fix.sigma_m.z() = kUnknownHeightSigmaM;
      fix.position_in_enu_m =
          has_height ? frame.EnuFromWgs84({p.position.lat_deg, p.position.lon_deg, *p.height_ellipsoid_m})
                     : frame.EnuAtHeight(p.position, at.height_above_ground_m.value_or(0.0));
      series.positions.push_back(fix);
    }
    if (photo->velocity_in_enu_mps) {
      VelocityFix fix;
      fix.t_s = at.t_s;
      fix.velocity_in_enu_mps = *photo->velocity_in_enu_mps;
      fix.sigma_mps = Vector3d(0.15, 0.15, 0.2);  // written with one decimal
      series.velocities.push_back(fix);
    }
  }
  return series;
}

std::vector<AttitudeFix> AttitudesOfLog(const std::vector<flight::AttitudeSample>& samples) {
  std::vector<AttitudeFix> fixes;
  for (const flight::AttitudeSample& s : samples) {
    if (!fixes.empty() && s.t_s < fixes.back().t_s + 0.095) continue;
    fixes.push_back({s.t_s, (EnuFromNed() * s.ned_from_body).normalized(), 0.0035, s.has_yaw});
  }
  return fixes;
}

std::vector<HeightFix> HeightsOfLog(const std::vector<flight::BaroSample>& samples) {
  std::vector<HeightFix> fixes;
  std::size_t k = 0;
  while (k < samples.size()) {
    double t = 0.0, z = 0.0;
    std::size_t n = 0;
    for (; k + n < samples.size() && samples[k + n].t_s < samples[k].t_s + 0.19; ++n) {
      t += samples[k + n].t_s;
      z += samples[k + n].height_above_takeoff_m;
    }
    fixes.push_back({t / static_cast<double>(n), z / static_cast<double>(n), 0.15});
    k += n;
  }
  return fixes;
}

std::vector<RangeFix> RangesOfLog(const std::vector<flight::RangeSample>& samples) {
  double longest = 0.0;
  for (const flight::RangeSample& s : samples) {
    if (std::isfinite(s.distance_m)) longest = std::max(longest, s.distance_m);
  }
  // A sensor out of reach repeats its limit; many samples at the longest value are that.
  const auto at_limit = std::count_if(samples.begin(), samples.end(), [&](const flight::RangeSample& s) {
    return s.distance_m >= 0.995 * longest;
  });
  const double reach = at_limit > 5 ? 0.99 * longest : longest;
  std::vector<RangeFix> fixes;
  for (const flight::RangeSample& s : samples) {
    if (!(s.distance_m > 0.2 && s.distance_m <= reach)) continue;
    if (!fixes.empty() && s.t_s < fixes.back().t_s + 0.19) continue;
    fixes.push_back({s.t_s, s.distance_m});
  }
  return fixes;
}

std::optional<ImuNoise> JudgeImu(const std::vector<flight::ImuSample>& samples) {
  if (samples.size() < 100) return std::nullopt;
  std::vector<double> steps, rates, forces;
  for (std::size_t k = 2; k < samples.size(); ++k) {
    const flight::ImuSample& a = samples[k - 2];
    const flight::ImuSample& b = samples[k - 1];
    const flight::ImuSample& c = samples[k];
    steps.push_back(c.t_s - b.t_s);
    rates.push_back((a.angular_rate_radps - 2.0 * b.angular_rate_radps + c.angular_rate_radps).squaredNorm());
    forces.push_back(
        (a.specific_force_mps2 - 2.0 * b.specific_force_mps2 + c.specific_force_mps2).squaredNorm());
  }
  const double dt = Median(std::move(steps));
  if (!(dt > 0.0) || dt > 0.05) return std::nullopt;
  // A second difference of white noise has six times its variance; a sum of three squares the median 2.37.
  const double fold = dt > 0.0125 ? 2.0 : 1.0;
  const double gyro = std::sqrt(Median(std::move(rates)) / (6.0 * 2.37) * dt) * fold;
  const double accel = std::sqrt(Median(std::move(forces)) / (6.0 * 2.37) * dt) * fold;
  ImuNoise noise;
  noise.gyro_white = std::max(noise.gyro_white, gyro);
  noise.accel_white = std::max(1.0e-3, accel);
  return noise;
}

std::vector<StillInterval> FindStillness(const std::vector<flight::ImuSample>& samples) {
  constexpr double kWindowS = 1.0;
  constexpr double kShortestS = 3.0;
  std::vector<StillInterval> still;
  std::size_t k = 0;
  while (k < samples.size()) {
    Vector3d rate = Vector3d::Zero(), rate2 = Vector3d::Zero(), force = Vector3d::Zero(),
             force2 = Vector3d::Zero();
    const std::size_t first = k;
    for (; k < samples.size() && samples[k].t_s < samples[first].t_s + kWindowS; ++k) {
      rate += samples[k].angular_rate_radps;
      rate2 += samples[k].angular_rate_radps.cwiseAbs2();
      force += samples[k].specific_force_mps2;
      force2 += samples[k].specific_force_mps2.cwiseAbs2();
    }
    const double n = static_cast<double>(k - first);
    if (n < 10.0) continue;
    const auto spread = [n](const Vector3d& sum, const Vector3d& squares) {
      return std::sqrt(std::max(0.0, (squares / n - (sum / n).cwiseAbs2()).maxCoeff()));
    };
    const bool is_still =
        spread(rate, rate2) < 0.01 && (rate / n).norm() < 0.05 && spread(force, force2) < 0.15;
    if (!is_still) continue;
    if (!still.empty() && samples[first].t_s - still.back().end_s < 0.2) {
      still.back().end_s = samples[k - 1].t_s;
    } else {
      still.push_back({samples[first].t_s, samples[k - 1].t_s});
    }
  }
  std::erase_if(still, [](const StillInterval& s) { return s.end_s - s.begin_s < kShortestS; });
  return still;
}

}  // namespace skyquilt::poses
