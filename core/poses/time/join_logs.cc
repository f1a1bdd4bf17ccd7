#include "core/poses/time/join_logs.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <list>

#include "core/base/median.h"
#include "core/poses/time/event_list.h"
#include "core/poses/time/log_cover.h"
#include "core/poses/time/order_logs.h"
#include "core/poses/time/stamped_photos.h"

namespace skyquilt::poses {
namespace {

using flight::FlightLog;
using flight::LaterBy;
using flight::RemarkCode;

// Two lists of the same exposures, where one of them has nothing else.
bool EventsMeet(const FlightLog& a, const FlightLog& b) { return SpanOfEvents(a).Meets(SpanOfEvents(b)); }

bool ShareASeries(const FlightLog& a, const FlightLog& b) {
  return (!a.imu.empty() && !b.imu.empty()) || (!a.attitude.empty() && !b.attitude.empty()) ||
         (!a.gnss.empty() && !b.gnss.empty()) || (!a.baro.empty() && !b.baro.empty());
}

bool NamesPhotos(const FlightLog& log) {
  return std::any_of(log.events.begin(), log.events.end(),
                     [](const auto& event) { return event.has_time && event.image_name.has_value(); });
}

bool PlacesPhotos(const FlightLog& log) {
  return std::any_of(log.events.begin(), log.events.end(),
                     [](const auto& event) { return event.has_time && event.position.has_value(); });
}

FlightLog Shifted(const FlightLog& log, double by_s) {
  FlightLog moved = log;
  const auto shift = [by_s](auto& samples) {
    for (auto& sample : samples) sample.t_s += by_s;
  };
  flight::ForEachSeries(shift, moved);
  std::erase_if(moved.events, [](const auto& event) { return !event.has_time; });
  shift(moved.events);
  return moved;
}

// Two series of which one ends before the other begins.
template <typename Sample>
void Append(std::vector<Sample>& into, std::vector<Sample> more) {
  into.insert(into.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
  std::stable_sort(into.begin(), into.end(), [](const Sample& a, const Sample& b) { return a.t_s < b.t_s; });
}

// Those that lie more than what two clocks differ by before or behind a span.
std::vector<flight::CameraEvent> TakeOutEventsBeside(const LogSpan& span,
                                                     std::vector<flight::CameraEvent>& events) {
  constexpr double kClocksApartS = 2.0;
  const auto beside =
      std::stable_partition(events.begin(), events.end(), [&](const flight::CameraEvent& event) {
        return event.t_s >= span.begin_s - kClocksApartS && event.t_s <= span.end_s + kClocksApartS;
      });
  std::vector<flight::CameraEvent> out(std::make_move_iterator(beside),
                                       std::make_move_iterator(events.end()));
  events.erase(beside, events.end());
  return out;
}

// The median of GNSS height minus barometric height: every log's barometer has its own zero.
std::optional<double> BaroZero(const FlightLog& log) {
  std::vector<double> zeros;
  std::size_t k = 0;
  for (const flight::GnssSample& fix : log.gnss) {
    const auto height = fix.height_ellipsoid_m ? fix.height_ellipsoid_m : fix.height_amsl_m;
    if (!height) continue;
    while (k < log.baro.size() && log.baro[k].t_s < fix.t_s) ++k;
    if (k == log.baro.size()) break;
    if (log.baro[k].t_s - fix.t_s < 1.0) zeros.push_back(*height - log.baro[k].height_above_takeoff_m);
  }
  if (zeros.empty()) return std::nullopt;
  return Median(std::move(zeros));
}

// How far two tracks lie from each other where both are; nothing where they are not.
std::optional<double> TracksApartM(const FlightLog& a, const FlightLog& b) {
  constexpr std::size_t kCompared = 500;
  if (a.gnss.empty()) return std::nullopt;
  const LogCover cover(a);
  std::vector<double> apart_m;
  const std::size_t step = std::max<std::size_t>(1, b.gnss.size() / kCompared);
  for (std::size_t i = 0; i < b.gnss.size(); i += step) {
    if (const auto at = cover.PositionAt(b.gnss[i].t_s))
      apart_m.push_back((*at - cover.InPlane(b.gnss[i].position)).norm());
  }
  return MedianIfAny(std::move(apart_m));
}

class Joiner {
 public:
  Joiner(const RankedLog& leader, double most_apart_s, JoinedLog& out)
      : merit_(leader.merit), most_apart_s_(most_apart_s), out_(out) {
    out_.log = Shifted(*leader.log, 0.0);
    out_.notes.push_back(fmt::format("{} ({})", leader.log->file_name, leader.log->format));
  }

  void Take(const RankedLog& ranked) {
    FlightLog& log = out_.log;
    const FlightLog& other = *ranked.log;
    const bool both_know_utc = log.utc_at_zero && other.utc_at_zero;
    if (!both_know_utc) {
      TakeByCounter(other);
      return;
    }
    const double shift_s = flight::SecondsBetween(*log.utc_at_zero, *other.utc_at_zero);
    FlightLog moved = Shifted(other, shift_s);
    const LogSpan here = SpanWithEvents(log), there = SpanWithEvents(moved);
    if (HoleBetweenS(here, there) > most_apart_s_) {
      out_.warnings.push_back({RemarkCode::kLogOfOtherDay,
                               {{"file", other.file_name},
                                {"log_from", DateInWords(LaterBy(*log.utc_at_zero, there.begin_s))},
                                {"other", log.file_name},
                                {"other_from", DateInWords(LaterBy(*log.utc_at_zero, here.begin_s))}}});
      return;
    }
    if (SpanOf(log).Meets(SpanOf(moved)) || EventsMeet(log, moved)) {
      Complete(std::move(moved), ranked.merit);
    } else {
      Lengthen(std::move(moved));
    }
    log.utc_sigma_s = std::max(log.utc_sigma_s, other.utc_sigma_s);
  }

 private:
  // Two tables without UTC that one recorder wrote count the same seconds: one holds what the other lacks,
  // and its times fall into the other's.
  void TakeByCounter(const FlightLog& other) {
    FlightLog& log = out_.log;
    const std::string& without_utc = log.utc_at_zero ? other.file_name : log.file_name;
    if (!log.counter_at_zero_s || !other.counter_at_zero_s || ShareASeries(log, other)) {
      out_.warnings.push_back(
          {RemarkCode::kLogWithoutUtc, {{"file", other.file_name}, {"without", without_utc}}});
      return;
    }
    FlightLog moved = Shifted(other, *other.counter_at_zero_s - *log.counter_at_zero_s);
    const LogSpan here = SpanWithEvents(log);
    const LogSpan there = SpanWithEvents(moved);
    const double shared_s = std::min(here.end_s, there.end_s) - std::max(here.begin_s, there.begin_s);
    const double shorter_s = std::min(here.end_s - here.begin_s, there.end_s - there.begin_s);
    if (shared_s < 0.5 * shorter_s) {
      const double zero_s = *log.counter_at_zero_s;
      out_.warnings.push_back({RemarkCode::kLogOfOtherSeconds,
                               {{"file", other.file_name},
                                {"from_s", there.begin_s + zero_s},
                                {"until_s", there.end_s + zero_s},
                                {"other", log.file_name},
                                {"other_from_s", here.begin_s + zero_s},
                                {"other_until_s", here.end_s + zero_s},
                                {"without", without_utc}}});
      return;
    }
    Complete(std::move(moved), {});
    out_.notes.back() += fmt::format(", its times being those that {} counts", log.file_name);
  }

  // Another flight of the same mission.
  void Lengthen(FlightLog more) {
    FlightLog& log = out_.log;
    const auto zero_here = BaroZero(log);
    const auto zero_there = BaroZero(more);
    if (zero_here && zero_there) {
      for (auto& sample : more.baro) sample.height_above_takeoff_m += *zero_there - *zero_here;
    } else if (!more.baro.empty() && !log.baro.empty()) {
      more.baro.clear();  // heights over an unknown zero
    }
    out_.notes.push_back(fmt::format("{} ({}), another part of the flight", more.file_name, more.format));
    flight::ForEachSeries([](auto& into, auto& from) { Append(into, std::move(from)); }, log, more);
    Append(log.events, std::move(more.events));
  }

  // A second track of the same time, where the two do not agree: which of them counts is said.
  void SayOtherTrack(const FlightLog& more, double apart_m, const LogMerit& merit) {
    out_.warnings.push_back({RemarkCode::kTrackOfSameTime,
                             {{"file", more.file_name},
                              {"other", out_.log.file_name},
                              {"apart_m", apart_m},
                              {"why", WhyBefore(merit_, merit)}}});
  }

  void Complete(FlightLog more, const LogMerit& merit) {
    FlightLog& log = out_.log;
    // Receivers without corrections agree within some metres.
    constexpr double kAgreeWithinM = 5.0;
    std::optional<double> apart_m;
    if (merit.is_compared) apart_m = TracksApartM(log, more);
    if (apart_m && *apart_m < kAgreeWithinM) apart_m.reset();
    // It lay at the start, or in a pocket: nothing of it is the aircraft's.
    if (merit.stands && apart_m) {
      out_.notes.push_back(
          fmt::format("{} ({}) stood while the photos were taken", more.file_name, more.format));
      SayOtherTrack(more, *apart_m, merit);
      return;
    }
    std::string taken;
    const auto fill = [&taken](auto& into, auto& from, const char* what, bool is_better) {
      if (from.empty() || (!into.empty() && !is_better)) return;
      into = std::move(from);
      taken += fmt::format("{}{}", taken.empty() ? "" : ", ", what);
    };
    // A base station's track is corrected too.
    const bool is_elsewhere = apart_m && merit_.ties && !merit.ties;
    const bool better_track = IsMostlyFixed(more.gnss) && !IsMostlyFixed(log.gnss) && !is_elsewhere;
    if (apart_m && !better_track) SayOtherTrack(more, *apart_m, merit);
    const auto surveyed = [](const std::vector<flight::CameraEvent>& events) {
      return std::any_of(events.begin(), events.end(),
                         [](const auto& e) { return e.is_rtk_fixed && e.position; });
    };
    fill(log.gnss, more.gnss, "positions", better_track);
    fill(log.imu, more.imu, "inertial samples", false);
    fill(log.attitude, more.attitude, "attitude", false);
    fill(log.baro, more.baro, "barometer", false);
    fill(log.range, more.range, "range finder", false);
    fill(log.gimbal, more.gimbal, "gimbal", false);
    // A surveyed list may be of one battery only: of other times the log's own events stay.
    std::vector<flight::CameraEvent> elsewhere;
    if (surveyed(more.events)) elsewhere = TakeOutEventsBeside(SpanOfEvents(more), log.events);
    const bool better_named = NamesPhotos(more) && !NamesPhotos(log) && !surveyed(log.events);
    // Of two lists of the same photos one has lost its positions to the other (lists/choose_rows.h).
    const bool better_placed =
        NamesPhotos(more) && NamesPhotos(log) && PlacesPhotos(more) && !PlacesPhotos(log);
    fill(log.events, more.events, "camera events",
         better_named || better_placed || (surveyed(more.events) && !surveyed(log.events)));
    Append(log.events, std::move(elsewhere));
    if (taken.empty()) {
      out_.notes.push_back(fmt::format("{} ({}) adds nothing", more.file_name, more.format));
      if (!apart_m) out_.warnings.push_back({RemarkCode::kLogAddsNothing, {{"file", more.file_name}}});
    } else {
      out_.notes.push_back(fmt::format("{} ({}) for {}", more.file_name, more.format, taken));
    }
  }

  LogMerit merit_;  // of the log that leads
  double most_apart_s_;
  JoinedLog& out_;
};

}  // namespace

std::vector<flight::Remark> WarnOfEmptyLogs(const std::vector<FlightLog>& logs) {
  std::vector<flight::Remark> warnings;
  for (const FlightLog& log : logs) {
    if (Worth(log) > 0 || !log.events.empty()) continue;
    warnings.push_back({RemarkCode::kLogEmpty, {{"file", log.file_name}, {"format", log.format}}});
  }
  return warnings;
}

std::optional<JoinedLog> JoinLogs(const std::vector<FlightLog>& logs,
                                  const std::vector<flight::Photo>& photos) {
  std::vector<const FlightLog*> useful;
  std::list<FlightLog> event_lists;
  JoinedLog out;
  for (const FlightLog& log : logs) {
    if (auto list = AsEventList(log, photos)) {
      out.notes.push_back(fmt::format("{} ({}): its {} positions are those of camera events", log.file_name,
                                      log.format, list->events.size()));
      useful.push_back(&event_lists.emplace_back(*std::move(list)));
    } else if (Worth(log) > 0) {
      useful.push_back(&log);
    }
  }
  if (useful.empty()) return std::nullopt;
  const std::vector<RankedLog> ranked = OrderLogs(useful, photos);
  Joiner joiner(ranked.front(), MostApartS(photos), out);
  for (std::size_t i = 1; i < ranked.size(); ++i) joiner.Take(ranked[i]);
  return out;
}

}  // namespace skyquilt::poses
