#include "core/poses/time/tie_to_log.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/flight/remarks/because.h"
#include "core/poses/photo_rows.h"
#include "core/poses/time/log_cover.h"

namespace skyquilt::poses {
namespace {

// A log covers a photo up to this long before its first and after its last sample, and up to half of the
// usual interval of sparse positions: a caption holds until the next one begins.
constexpr double kBeyondLogS = 1.0, kFurthestBeyondLogS = 5.0;
constexpr double kEventClockSigmaS = 0.005;
// Into a hole of the log (that of one battery is not here) its track leads a photo that knows no place of its
// own, so far.
constexpr double kLedIntoAHoleS = 30.0;

bool HasTrackSeries(const flight::FlightLog& log) {
  return !log.imu.empty() || !log.attitude.empty() || log.gnss.size() >= 2;
}

LogSpan MotionSpanOf(const flight::FlightLog& log) {
  LogSpan span;
  span.Take(log.gnss);
  span.Take(log.attitude);
  span.Take(log.imu);
  return span;
}

// Of this photo's time alone: what all share by the camera's clock is stated apart.
double OwnSigmaS(const PhotoTime& time, double clock_sigma_s) {
  if (time.event) return time.sigma_s;
  return std::sqrt(std::max(0.0, time.sigma_s * time.sigma_s - clock_sigma_s * clock_sigma_s));
}

}  // namespace

LogTie TieToLog(const flight::FlightLog& log, std::vector<flight::Photo> photos) {
  LogTie tie;
  tie.photos = std::move(photos);
  if (tie.photos.empty()) return tie;
  Result<TimeSync> sync = MatchPhotosToLog(tie.photos, log);
  if (!sync) {
    tie.warnings.push_back(flight::WhyOf(sync.error()));
    return tie;
  }
  tie.sync = *std::move(sync);
  tie.warnings = tie.sync->warnings;
  int placed_by_events = ApplyEvents(log, *tie.sync, log.gnss.size() >= 2, tie.photos);
  if (!HasTrackSeries(log)) {
    if (const int between = PlaceBetweenEvents(log, *tie.sync, tie.photos); between > 0) {
      placed_by_events += between;
      tie.sync->notes.push_back(
          fmt::format("{} without an event of {} own stand{} between those before and after", between,
                      between == 1 ? "its" : "their", between == 1 ? "s" : ""));
    }
  }
  tie.clock_sigma_s = kEventClockSigmaS;
  if (!HasTrackSeries(log)) return tie;
  const LogSpan span = MotionSpanOf(log);
  const LogCover cover(log);
  const double beyond_s = std::clamp(0.5 * UsualIntervalS(log.gnss), kBeyondLogS, kFurthestBeyondLogS);
  for (std::size_t i = 0; i < tie.photos.size(); ++i) {
    const auto& time = tie.sync->photos[i];
    if (!time || time->t_s < span.begin_s - beyond_s || time->t_s > span.end_s + beyond_s) continue;
    if (!cover.Covers(time->t_s, tie.photos[i].position ? kCoversBeyondS : kLedIntoAHoleS)) continue;
    tie.tied.push_back({i, time->t_s, OwnSigmaS(*time, tie.sync->sigma_s)});
    if (!time->event) tie.clock_sigma_s = tie.sync->sigma_s;
  }
  if (tie.tied.empty() && placed_by_events == 0) {
    tie.warnings.push_back({flight::RemarkCode::kLogOfOtherTime, {{"file", log.file_name}}});
  }
  std::stable_sort(tie.tied.begin(), tie.tied.end(),
                   [](const TiedPhoto& a, const TiedPhoto& b) { return a.t_s < b.t_s; });
  return tie;
}

std::optional<double> AirframeYawAt(const flight::FlightLog& log, double t_s) {
  const auto next = std::lower_bound(log.attitude.begin(), log.attitude.end(), t_s,
                                     [](const flight::AttitudeSample& s, double t) { return s.t_s < t; });
  if (next == log.attitude.end() || !next->has_yaw || next->t_s - t_s > 1.0) return std::nullopt;
  const Eigen::Vector3d nose = next->ned_from_body * Eigen::Vector3d::UnitX();
  return std::atan2(nose.y(), nose.x());
}

}  // namespace skyquilt::poses
