#include "core/poses/time/order_logs.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/base/median.h"
#include "core/poses/time/log_cover.h"
#include "core/poses/time/stamped_photos.h"
#include "core/poses/time/time_sync.h"

namespace skyquilt::poses {
namespace {

using flight::FlightLog;
using flight::Photo;
using flight::RemarkCode;

// Logs that are compared, each by a tie of its own; of more, the order of their kinds decides alone.
constexpr std::size_t kMaxCompared = 24;

LogSpan Later(LogSpan span, double by_s) {
  span.begin_s += by_s;
  span.end_s += by_s;
  return span;
}

// Two tracks of one time, or logs that cannot be of one flight.
bool IsThereAChoice(const std::vector<const FlightLog*>& logs, double most_apart_s, bool& are_days_apart) {
  bool are_rivals = false;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const FlightLog &a = *logs[i], &b = *logs[j];
      if (!a.utc_at_zero || !b.utc_at_zero) continue;
      const double shift_s = flight::SecondsBetween(*a.utc_at_zero, *b.utc_at_zero);
      if (HoleBetweenS(SpanWithEvents(a), Later(SpanWithEvents(b), shift_s)) > most_apart_s)
        are_days_apart = true;
      LogSpan track_a, track_b;
      track_a.Take(a.gnss);
      track_b.Take(b.gnss);
      are_rivals =
          are_rivals || (a.gnss.size() >= 2 && b.gnss.size() >= 2 && track_a.Meets(Later(track_b, shift_s)));
    }
  }
  return are_rivals || are_days_apart;
}

LogMerit MeritOf(const FlightLog& log, const std::vector<Photo>& photos) {
  constexpr double kNearM = 30.0;  // a receiver's error, and a second of flight
  constexpr double kFurthestZoneS = 15.0 * 3600.0;
  LogMerit merit;
  merit.is_compared = true;
  merit.worth = Worth(log);
  merit.is_fixed = IsMostlyFixed(log.gnss);
  std::vector<double> sigmas_m;
  for (const flight::GnssSample& sample : log.gnss)
    if (sample.sigma_horizontal_m) sigmas_m.push_back(*sample.sigma_horizontal_m);
  if (!sigmas_m.empty()) merit.sigma_m = Median(std::move(sigmas_m));
  const auto sync = MatchPhotosToLog(photos, log);
  if (!sync) return merit;
  merit.ties = std::abs(sync->camera_ahead_of_utc_s.value_or(0.0)) <= kFurthestZoneS;
  if (log.gnss.size() < 2) return merit;
  const LogCover cover(log);
  std::vector<double> times_s;
  std::size_t covered = 0, near = 0, placed = 0;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (photos[i].position) ++placed;
    if (!sync->photos[i]) continue;
    times_s.push_back(sync->photos[i]->t_s);
    const auto at = cover.PositionAt(times_s.back());
    if (!at) continue;
    ++covered;
    if (photos[i].position && (*at - cover.InPlane(photos[i].position->position)).norm() <= kNearM) ++near;
  }
  std::sort(times_s.begin(), times_s.end());
  merit.moves = cover.WayM(times_s) > kStandsWithinM;
  merit.covered_tenths = static_cast<int>(10 * covered / photos.size());
  if (placed > 0) merit.near_tenths = static_cast<int>(10 * near / placed);
  return merit;
}

}  // namespace

int Worth(const FlightLog& log) {
  return (log.imu.empty() ? 0 : 8) + (log.attitude.empty() ? 0 : 8) + (log.gnss.empty() ? 0 : 4) +
         (log.baro.empty() ? 0 : 1) + (log.range.empty() ? 0 : 1) + (HasTimedEvents(log) ? 1 : 0);
}

LogSpan SpanOf(const FlightLog& log) {
  LogSpan span;
  span.Take(log.imu);
  span.Take(log.attitude);
  span.Take(log.gnss);
  span.Take(log.baro);
  return span;
}

LogSpan SpanOfEvents(const FlightLog& log, LogSpan span) {
  for (const flight::CameraEvent& event : log.events) {
    if (event.has_time) span.Take(event.t_s);
  }
  return span;
}

LogSpan SpanWithEvents(const FlightLog& log) { return SpanOfEvents(log, SpanOf(log)); }

bool IsMostlyFixed(const std::vector<flight::GnssSample>& samples) {
  const auto fixed =
      std::count_if(samples.begin(), samples.end(), [](const auto& s) { return s.is_rtk_fixed; });
  return 2 * fixed > static_cast<std::ptrdiff_t>(samples.size());
}

double HoleBetweenS(const LogSpan& a, const LogSpan& b) {
  if (a.IsEmpty() || b.IsEmpty()) return 0.0;
  return std::max({0.0, a.begin_s - b.end_s, b.begin_s - a.end_s});
}

double MostApartS(const std::vector<Photo>& photos) {
  constexpr double kDayS = 86400.0;
  constexpr double kUnknownDaysS = 31.0 * kDayS;  // photos without times may be of several days
  const auto first = FirstStamp(photos);
  if (!first) return kUnknownDaysS;
  double span_s = 0.0;
  for (const Photo& photo : photos)
    if (photo.captured_at) span_s = std::max(span_s, flight::SecondsBetween(*first, *photo.captured_at));
  return kDayS + span_s;
}

std::vector<RankedLog> OrderLogs(const std::vector<const FlightLog*>& logs,
                                 const std::vector<Photo>& photos) {
  std::vector<RankedLog> ranked;
  for (const FlightLog* log : logs) ranked.push_back({log, {}});
  const auto by_worth = [](const RankedLog& a, const RankedLog& b) { return Worth(*a.log) > Worth(*b.log); };
  std::stable_sort(ranked.begin(), ranked.end(), by_worth);
  bool are_days_apart = false;
  if (photos.empty() || logs.size() < 2 || logs.size() > kMaxCompared ||
      !IsThereAChoice(logs, MostApartS(photos), are_days_apart))
    return ranked;
  for (RankedLog& one : ranked) one.merit = MeritOf(*one.log, photos);
  const bool any_moves =
      std::any_of(ranked.begin(), ranked.end(), [](const RankedLog& one) { return one.merit.moves; });
  for (auto& [log, merit] : ranked)
    merit.stands = any_moves && merit.ties && !merit.moves && log->gnss.size() >= 2;
  std::stable_sort(ranked.begin(), ranked.end(), [&](const RankedLog& one, const RankedLog& other) {
    const auto key = [&](const LogMerit& m) {
      return std::tuple(are_days_apart && !m.ties, m.stands, -m.worth, !m.ties, -m.covered_tenths,
                        -m.near_tenths, !m.is_fixed, m.sigma_m);
    };
    return key(one.merit) < key(other.merit);
  });
  return ranked;
}

flight::Remark WhyBefore(const LogMerit& used, const LogMerit& other) {
  if (other.stands) return RemarkCode::kTrackStands;
  if (used.ties != other.ties) return used.ties ? RemarkCode::kTrackUntied : RemarkCode::kTrackPoorer;
  if (used.worth != other.worth) return RemarkCode::kTrackPoorer;
  if (used.covered_tenths > other.covered_tenths) return RemarkCode::kTrackShorter;
  if (used.near_tenths > other.near_tenths) return RemarkCode::kTrackFarther;
  if (used.is_fixed != other.is_fixed || used.sigma_m < other.sigma_m) return RemarkCode::kTrackCoarser;
  return RemarkCode::kTrackUndecided;
}

}  // namespace skyquilt::poses
