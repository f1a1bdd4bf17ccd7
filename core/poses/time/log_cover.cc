#include "core/poses/time/log_cover.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace skyquilt::poses {
namespace {

// A logger that writes where the course changes is silent for seconds on a straight leg; the holes between
// two logs last minutes.
constexpr double kLongestSilenceS = 10.0, kUsualIntervals = 5.0;

template <typename Sample>
void AddStretches(const std::vector<Sample>& samples, std::vector<LogSpan>& stretches) {
  if (samples.empty()) return;
  const double hole_s = std::max(kLongestSilenceS, kUsualIntervals * UsualIntervalS(samples));
  LogSpan stretch{samples.front().t_s, samples.front().t_s};
  for (const Sample& sample : samples) {
    if (sample.t_s - stretch.end_s > hole_s) {
      stretches.push_back(stretch);
      stretch.begin_s = sample.t_s;
    }
    stretch.end_s = sample.t_s;
  }
  stretches.push_back(stretch);
}

void MergeStretches(std::vector<LogSpan>& stretches) {
  std::sort(stretches.begin(), stretches.end(),
            [](const LogSpan& a, const LogSpan& b) { return a.begin_s < b.begin_s; });
  std::vector<LogSpan> merged;
  for (const LogSpan& stretch : stretches) {
    if (merged.empty() || merged.back().end_s < stretch.begin_s)
      merged.push_back(stretch);
    else
      merged.back().end_s = std::max(merged.back().end_s, stretch.end_s);
  }
  stretches = std::move(merged);
}

}  // namespace

LogCover::LogCover(const flight::FlightLog& log) {
  AddStretches(log.gnss, stretches_);
  AddStretches(log.attitude, stretches_);
  AddStretches(log.imu, stretches_);
  AddStretches(log.baro, stretches_);
  if (stretches_.empty()) {
    // Events tell by where they were; one without a place tells nothing, whatever its time.
    LogSpan placed;
    for (const flight::CameraEvent& event : log.events) {
      if (event.has_time && event.position) placed.Take(event.t_s);
    }
    if (!placed.IsEmpty()) stretches_.push_back(placed);
  }
  MergeStretches(stretches_);
  if (log.gnss.empty()) return;
  const geo::LatLon& origin = log.gnss.front().position;
  frame_.emplace(geo::Wgs84{origin.lat_deg, origin.lon_deg, 0.0});
  for (const flight::GnssSample& sample : log.gnss) {
    times_s_.push_back(sample.t_s);
    positions_m_.push_back(InPlane(sample.position));
  }
}

Eigen::Vector2d LogCover::InPlane(const geo::LatLon& position) const {
  return frame_->EnuFromWgs84({position.lat_deg, position.lon_deg, 0.0}).head<2>();
}

bool LogCover::Covers(double t_s, double beyond_s) const {
  const auto after = std::upper_bound(stretches_.begin(), stretches_.end(), t_s + beyond_s,
                                      [](double t, const LogSpan& stretch) { return t < stretch.begin_s; });
  return after != stretches_.begin() && t_s <= (after - 1)->end_s + beyond_s;
}

std::optional<Eigen::Vector2d> LogCover::PositionAt(double t_s) const {
  if (times_s_.empty() || !Covers(t_s)) return std::nullopt;
  const auto after = std::lower_bound(times_s_.begin(), times_s_.end(), t_s);
  if (after == times_s_.begin()) return positions_m_.front();
  if (after == times_s_.end()) return positions_m_.back();
  const auto i = static_cast<std::size_t>(after - times_s_.begin());
  const double interval_s = times_s_[i] - times_s_[i - 1];
  const double share = interval_s > 0.0 ? (t_s - times_s_[i - 1]) / interval_s : 1.0;
  return positions_m_[i - 1] + share * (positions_m_[i] - positions_m_[i - 1]);
}

double LogCover::WayM(const std::vector<double>& times_s) const {
  std::optional<Eigen::Vector2d> first;
  double way_m = 0.0;
  for (const double t_s : times_s) {
    const auto at = PositionAt(t_s);
    if (!at) continue;
    if (!first) first = at;
    way_m = std::max(way_m, (*at - *first).norm());
  }
  return way_m;
}

bool LogCover::PhotosRunOn(const std::vector<double>& times_s) const {
  constexpr double kPauseS = 19.5;
  for (std::size_t k = 1; k < times_s.size(); ++k) {
    if (times_s[k] - times_s[k - 1] < kPauseS && Covers(times_s[k]) != Covers(times_s[k - 1])) return true;
  }
  return false;
}

bool LogCover::AreOthersOfGround(const std::vector<double>& times_s) const {
  const bool any_before = std::any_of(times_s.begin(), times_s.end(), [&](double t_s) {
    return t_s < stretches_.front().begin_s && !Covers(t_s);
  });
  const bool any_after = std::any_of(times_s.begin(), times_s.end(), [&](double t_s) {
    return t_s > stretches_.back().end_s && !Covers(t_s);
  });
  return !PhotosRunOn(times_s) || (any_before && any_after);
}

bool LogCover::IsCutWhereItLacks(const std::vector<double>& times_s) const {
  return std::all_of(times_s.begin(), times_s.end(),
                     [&](double t_s) { return Covers(t_s) || IsCutNear(t_s); });
}

bool LogCover::IsCutNear(double t_s) const {
  constexpr double kLookS = 3.0, kMovesMps = 1.0;
  const auto moves = [&](double from_s, double to_s) {
    const auto from = PositionAt(from_s), to = PositionAt(to_s);
    return from && to && (*to - *from).norm() > kMovesMps * (to_s - from_s);
  };
  const auto after = std::upper_bound(stretches_.begin(), stretches_.end(), t_s,
                                      [](double t, const LogSpan& stretch) { return t < stretch.begin_s; });
  if (after != stretches_.begin() && moves((after - 1)->end_s - kLookS, (after - 1)->end_s)) return true;
  return after != stretches_.end() && moves(after->begin_s, after->begin_s + kLookS);
}

}  // namespace skyquilt::poses
