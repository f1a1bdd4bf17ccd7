#include "core/poses/time/receiver_days.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/median.h"
#include "core/flight/bytes/gps_time.h"
#include "core/poses/time/stamped_photos.h"

namespace skyquilt::poses {
namespace {

// Leap seconds, a receiver's last fix written again, a recorder that was started before its first fix.
constexpr double kClocksAgreeS = 300.0;
// Logs whose times name no zone are read as UTC: they are off by halves of hours, and little else.
constexpr double kHalfHourS = 1800.0, kBesideZoneS = 30.0, kWidestZoneS = 14.0 * 3600.0;
// A log whose UTC is no better than this has it from the clock of a ground station, say.
constexpr double kUnsureUtcS = 2.0;
// A receiver's times go on with the photos; one time that all photos carry is the last one that it knew.
constexpr double kGoesOnWithinS = 120.0;

bool CanBeTheSame(double apart_s) {
  const double of_days_s = std::abs(std::remainder(apart_s, flight::kGpsWeeksRunOverS));
  if (of_days_s <= kClocksAgreeS) return true;
  return of_days_s <= kWidestZoneS && std::abs(std::remainder(of_days_s, kHalfHourS)) <= kBesideZoneS;
}

}  // namespace

std::optional<flight::Remark> WhyOfAnotherDay(const std::vector<flight::Photo>& photos,
                                              const flight::FlightLog& log, const TimeSync& sync) {
  if (!log.utc_at_zero || log.utc_sigma_s > kUnsureUtcS) return std::nullopt;
  std::vector<double> apart_s;
  std::optional<std::pair<flight::UtcTime, flight::UtcTime>> first;  // the receiver's, the log's
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!photos[i].receiver_time || !sync.photos[i]) continue;
    const flight::UtcTime there = flight::LaterBy(*log.utc_at_zero, sync.photos[i]->t_s);
    apart_s.push_back(flight::SecondsBetween(*photos[i].receiver_time, there));
    if (!first || *photos[i].receiver_time < first->first) first.emplace(*photos[i].receiver_time, there);
  }
  if (apart_s.empty()) return std::nullopt;
  const auto [least_s, most_s] = std::minmax_element(apart_s.begin(), apart_s.end());
  if (*most_s - *least_s > kGoesOnWithinS || CanBeTheSame(Median(apart_s))) return std::nullopt;
  return flight::Remark{flight::RemarkCode::kNotTiedOfAnotherDay,
                        {{"photos", photos.size()},
                         {"file", log.file_name},
                         {"taken_from", DateInWords(first->first)},
                         {"log_from", DateInWords(first->second)}}};
}

}  // namespace skyquilt::poses
