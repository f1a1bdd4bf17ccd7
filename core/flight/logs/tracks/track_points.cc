#include "core/flight/logs/tracks/track_points.h"

#include <algorithm>

#include "core/base/text/printable.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {

std::optional<WrittenTime> TrackTime(std::string_view text) {
  if (const auto written = ParseWrittenTime(text)) return written;
  const auto number = ParseNumber(text);
  // Of 1973 to 2286, in whichever unit.
  constexpr double kEarliest = 1e8, kLatest = 1e10;
  if (!number) return std::nullopt;
  for (const double unit_s : {1.0, 1e-3, 1e-6}) {
    const double seconds = *number * unit_s;
    if (seconds < kEarliest || seconds >= kLatest) continue;
    return WrittenTime{LaterBy(UtcTime(), seconds), true, unit_s};
  }
  return std::nullopt;
}

TrackPoints::TrackPoints(std::string_view format, std::string_view file_name, BareTime bare_time)
    : format_(format), file_name_(file_name), bare_time_(bare_time) {}

void TrackPoints::Add(const std::optional<TrackPoint>& point, std::string_view written_time) {
  ++points_;
  const auto time = TrackTime(written_time);
  const bool is_on_earth = point && geo::LatLon::Make(point->lat_deg, point->lon_deg).ok();
  if (Trim(written_time).empty()) {
    ++without_time_;
  } else if (!time && ++unread_times_ == 1) {
    first_unread_time_ = Quoted(Trim(written_time));
  }
  if (!is_on_earth) ++without_place_;
  if (!is_on_earth || !time || placed_.size() >= kMaxTrackPoints) return;
  if (!time->names_zone) ++without_zone_;
  placed_.push_back({time->time, *point});
}

Error TrackPoints::WhyNone() const {
  const auto why = [&](RemarkCode code) {
    return Because(ErrorCode::kNoPosition, {code, {{"file", file_name_}, {"points", points_}}});
  };
  if (points_ == 0) return Because(ErrorCode::kNoPosition, {RemarkCode::kTrackEmpty, {{"file", file_name_}}});
  if (without_place_ == points_) return why(RemarkCode::kTrackWithoutPlaces);
  if (without_time_ == points_) return why(RemarkCode::kTrackWithoutTimes);
  if (unread_times_ == 0) return why(RemarkCode::kTrackNothingPlaced);
  return Because(ErrorCode::kNoPosition, {RemarkCode::kTrackTimesUnread,
                                          {{"file", file_name_},
                                           {"points", points_},
                                           {"unread", unread_times_},
                                           {"first", first_unread_time_}}});
}

Result<FlightLog> TrackPoints::Finish(std::vector<std::string> mapping) && {
  std::stable_sort(placed_.begin(), placed_.end(),
                   [](const Placed& a, const Placed& b) { return a.time < b.time; });
  LogBuilder builder(format_, file_name_);
  for (const Placed& placed : placed_) {
    const double t_s = SecondsBetween(placed_.front().time, placed.time);
    GnssSample sample;
    sample.t_s = t_s;
    sample.position = {placed.point.lat_deg, placed.point.lon_deg};
    sample.height_amsl_m = placed.point.height_amsl_m;
    sample.height_ellipsoid_m = placed.point.height_ellipsoid_m;
    builder.Add(sample);
    if (placed.point.height_above_takeoff_m)
      builder.Add(BaroSample{t_s, *placed.point.height_above_takeoff_m});
  }
  if (builder.gnss_count() == 0) return WhyNone();
  builder.Count("point", points_);
  FlightLog& log = builder.log();
  log.mapping = std::move(mapping);
  log.utc_sigma_s = 0.5;  // most recorders write whole seconds
  if (without_zone_ == placed_.size() && bare_time_ == BareTime::kLocal) {
    log.local_at_zero = placed_.front().time;
    builder.Warn(RemarkCode::kTimesTakenAsLocal);
  } else {
    log.utc_at_zero = placed_.front().time;
    if (without_zone_ > 0) builder.Warn({RemarkCode::kTimesTakenAsUtc, {{"times_read", without_zone_}}});
  }
  if (const auto bad = points_ - placed_.size(); bad > 0) {
    Remark skipped{RemarkCode::kPointsSkipped,
                   {{"skipped", bad},
                    {"points", points_},
                    {"without_place", without_place_},
                    {"without_time", without_time_}}};
    if (unread_times_ > 0) {
      skipped.code = RemarkCode::kPointsSkippedAndUnread;
      skipped.values.emplace("unread", unread_times_);
      skipped.values.emplace("first", first_unread_time_);
    }
    builder.Warn(std::move(skipped));
  }
  if (placed_.size() == kMaxTrackPoints)
    builder.Warn({RemarkCode::kPointsBeyond, {{"most", kMaxTrackPoints}}});
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
