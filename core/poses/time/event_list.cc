#include "core/poses/time/event_list.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/median.h"
#include "core/poses/lists/named_photos.h"
#include "core/poses/time/event_alignment.h"
#include "core/poses/time/stamped_photos.h"

namespace skyquilt::poses {
namespace {

using flight::FlightLog;

constexpr double kShutterJitterS = 0.02;
constexpr std::size_t kFewestRows = 4, kFewestNamedRows = 2;

bool HoldsPositionsAlone(const FlightLog& log) {
  return log.imu.empty() && log.attitude.empty() && log.baro.empty() && log.range.empty() &&
         log.gimbal.empty() && !HasTimedEvents(log);
}

bool IsNamedSo(const std::string& file_name) {
  return PlainFileName(file_name).find("_event") != std::string::npos;
}

std::vector<double> IntervalsOf(const std::vector<double>& times_s) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < times_s.size(); ++i) intervals.push_back(times_s[i] - times_s[i - 1]);
  return intervals;
}

// As a recorder writes: at one interval, now and then with some of them missing.
bool IsSampledEvenly(const std::vector<double>& times_s) {
  const std::vector<double> intervals = IntervalsOf(times_s);
  const double usual = Median(intervals);
  if (usual <= 0.0) return true;
  const double tolerance = std::max(0.02, 0.01 * usual);
  const auto even = std::count_if(intervals.begin(), intervals.end(), [&](double interval) {
    return std::abs(std::remainder(interval, usual)) <= tolerance;
  });
  return 5 * even >= 4 * static_cast<std::ptrdiff_t>(intervals.size());
}

// All rows are so long before or after their photo that the stamps' unit explains what differs.
bool FitsInOrder(const std::vector<double>& stamps_s, const std::vector<double>& times_s,
                 const StampModel& model) {
  double least = stamps_s[0] - times_s[0], most = least;
  for (std::size_t i = 1; i < stamps_s.size(); ++i) {
    least = std::min(least, stamps_s[i] - times_s[i]);
    most = std::max(most, stamps_s[i] - times_s[i]);
  }
  return most - least <= model.Spread();
}

// By how many rows a list and its photos may differ.
std::size_t FewMore(std::size_t photos) { return std::max<std::size_t>(3, photos / 10); }

bool HasRhythmOf(const StampedPhotos& camera, const std::vector<double>& times_s) {
  const std::size_t photos = camera.stamp_s.size(), rows = times_s.size();
  const std::size_t apart = std::max(photos, rows) - std::min(photos, rows);
  if (photos < kFewestRows || apart > FewMore(photos)) return false;
  const StampModel model{camera.resolution_s, kShutterJitterS};
  if (apart == 0 && FitsInOrder(camera.stamp_s, times_s, model)) return true;
  if (IsSampledEvenly(times_s)) return false;
  constexpr std::size_t kVotes = 100'000;
  const auto alignment = AlignEvents(camera.stamp_s, times_s, model, kVotes);
  return alignment && alignment->ambiguous_by_s == 0.0 &&
         10 * alignment->matched >= 9 * std::min(photos, rows);
}

}  // namespace

std::optional<FlightLog> AsEventList(const FlightLog& log, const std::vector<flight::Photo>& photos) {
  if (photos.empty() || !HoldsPositionsAlone(log)) return std::nullopt;
  const std::size_t rows = log.gnss.size();
  const bool is_named_so = IsNamedSo(log.file_name);
  // A few rows tell nothing by their rhythm, and are as many as the photos.
  const bool is_short = is_named_so && rows >= kFewestNamedRows && rows == photos.size();
  if (rows < kFewestRows && !is_short) return std::nullopt;
  // A track, which has many more rows, costs no further look.
  if (!is_named_so && rows > photos.size() + FewMore(photos.size())) return std::nullopt;
  std::vector<double> times_s;
  for (const flight::GnssSample& row : log.gnss) times_s.push_back(row.t_s);
  constexpr double kFastestShutterS = 0.3;
  const bool is_no_track = is_named_so && Median(IntervalsOf(times_s)) >= kFastestShutterS &&
                           (rows <= 2 * photos.size() || !IsSampledEvenly(times_s));
  if (!is_no_track) {
    const std::vector<StampedPhotos> cameras = StampsByCamera(photos);
    if (cameras.empty() || !HasRhythmOf(cameras.front(), times_s)) return std::nullopt;
  }
  FlightLog list = log;
  list.gnss.clear();
  for (const flight::GnssSample& row : log.gnss) {
    flight::CameraEvent event;
    event.t_s = row.t_s;
    event.position = row.position;
    static_cast<flight::GnssHeights&>(event) = row;
    if (row.sigma_horizontal_m && row.sigma_vertical_m)
      event.sigma_in_ned_m = {*row.sigma_horizontal_m, *row.sigma_horizontal_m, *row.sigma_vertical_m};
    list.events.push_back(std::move(event));
  }
  return list;
}

}  // namespace skyquilt::poses
