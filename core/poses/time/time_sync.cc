#include "core/poses/time/time_sync.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/median.h"
#include "core/base/text/printable.h"
#include "core/flight/bytes/gps_time.h"
#include "core/flight/remarks/because.h"
#include "core/geo/geodesic.h"
#include "core/poses/lists/named_photos.h"
#include "core/poses/time/event_alignment.h"
#include "core/poses/time/find_clock_offset.h"
#include "core/poses/time/log_cover.h"
#include "core/poses/time/stamped_photos.h"

namespace skyquilt::poses {
namespace {

using flight::CameraEvent;
using flight::FlightLog;
using flight::Photo;

// Between a measured shutter, or a command, and the exposure, 1 sigma.
constexpr double kFeedbackJitterS = 0.02, kCommandJitterS = 0.05;

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

// Why `sync` cannot be true; nothing where it can, or where nobody knows. Photos whose time a receiver of
// GNSS told need no shift to a log that knows UTC; one that takes hours or days to fit is of another flight,
// however well its rhythm fits (a mission that is flown every week).
std::optional<flight::Remark> WhyOfAnotherDay(const std::vector<Photo>& photos, const FlightLog& log,
                                              const TimeSync& sync) {
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

class Synchroniser {
 public:
  Synchroniser(const std::vector<Photo>& photos, const FlightLog& log) : photos_(photos), log_(log) {
    sync_.photos.resize(photos.size());
    first_ = FirstStamp(photos);
    const bool any_feedback = std::any_of(log.events.begin(), log.events.end(),
                                          [](const CameraEvent& e) { return e.has_time && e.is_feedback; });
    for (std::size_t i = 0; i < log.events.size(); ++i) {
      const CameraEvent& event = log.events[i];
      if (event.has_time && (event.is_feedback || !any_feedback)) {
        event_index_.push_back(i);
        event_s_.push_back(event.t_s);
      }
    }
    jitter_s_ = any_feedback ? kFeedbackJitterS : kCommandJitterS;
  }

  Result<TimeSync> Run() {
    const std::vector<StampedPhotos> cameras = StampsByCamera(photos_);
    const bool done = ByNames() || ByEvents(cameras) || (!cameras.empty() && BySearch(cameras.front()));
    if (!done) {
      return flight::Because(ErrorCode::kUnprocessable, WhyNotTied(!cameras.empty()),
                             fmt::format("{} events, {} stamped cameras", event_s_.size(), cameras.size()));
    }
    FillFromOffset(cameras);
    // What lists say of photos that they name was believed, or not, before (lists/compare_sources.h).
    const bool is_believed = sync_.method == TimeSyncMethod::kEventNames && HasPlacedEvents();
    if (auto why = is_believed ? std::nullopt : WhyOfAnotherDay(photos_, log_, sync_))
      return flight::Because(ErrorCode::kUnprocessable, *std::move(why));
    if (first_ && log_.utc_at_zero) {
      sync_.camera_ahead_of_utc_s = flight::SecondsBetween(*log_.utc_at_zero, *first_) - sync_.offset_s;
    }
    return std::move(sync_);
  }

 private:
  flight::Remark WhyNotTied(bool has_stamps) const {
    using flight::Remark;
    using flight::RemarkCode;
    if (event_s_.empty()) {
      if (why_not_found_) return *why_not_found_;
      return {RemarkCode::kNotTiedNoEvents,
              {{"photos", photos_.size()}, {"file", log_.file_name}, {"positions", log_.gnss.size()}}};
    }
    const Remark why = open_by_s_ > 0.0 ? Remark(RemarkCode::kFitsElsewhere, {{"open_s", open_by_s_}})
                       : has_stamps     ? Remark(RemarkCode::kOtherIntervals)
                                        : Remark(RemarkCode::kOtherNumbers);
    return {
        RemarkCode::kNotTiedToEvents,
        {{"photos", photos_.size()}, {"file", log_.file_name}, {"events", event_s_.size()}, {"why", why}}};
  }

  void Place(std::size_t photo, std::size_t event, double sigma_s) {
    sync_.photos[photo] = PhotoTime{log_.events[event].t_s, sigma_s, event};
  }

  // Stamps minus event times of what is matched so far fix the offset.
  void OffsetFromMatches() {
    std::vector<double> differences;
    double resolution = 1e-3;
    for (const StampedPhotos& camera : StampsByCamera(photos_)) {
      for (std::size_t k = 0; k < camera.photo.size(); ++k) {
        const auto& placed = sync_.photos[camera.photo[k]];
        if (placed && placed->event) differences.push_back(camera.stamp_s[k] - placed->t_s);
      }
      resolution = std::max(resolution, camera.resolution_s);
    }
    if (differences.empty()) return;
    SetOffset(FitOffset(differences, {resolution, jitter_s_}), 0.0);
  }

  bool ByNames() {
    const std::vector<NamedPhotos::Found> found = NamedPhotos(photos_).FindAll(log_);
    std::size_t matched = 0, rows = 0;
    for (std::size_t i = 0; i < log_.events.size(); ++i) {
      const CameraEvent& event = log_.events[i];
      if (!event.has_time || !event.image_name) continue;
      ++rows;
      for (const std::size_t photo : found[i].photos) {
        if (sync_.photos[photo]) continue;
        Place(photo, i, jitter_s_);
        ++matched;
      }
    }
    // Rows that say where, and were held against the photos, count also where they name few of these.
    const bool are_of_list = HasPlacedEvents() && 2 * rows > event_s_.size();
    const std::size_t wanted = are_of_list ? std::min(rows, photos_.size()) : photos_.size();
    if (matched == 0 || 2 * matched < wanted) {
      sync_.photos.assign(photos_.size(), std::nullopt);
      return false;
    }
    sync_.method = TimeSyncMethod::kEventNames;
    sync_.method_in_words =
        fmt::format("{} of {} photos are named by the log's events", matched, photos_.size());
    sync_.sigma_s = jitter_s_;
    OffsetFromMatches();
    return true;
  }

  bool ByEvents(const std::vector<StampedPhotos>& cameras) {
    if (event_s_.empty()) return false;
    if (cameras.empty()) return ByCountAlone();
    bool any = false;
    for (const StampedPhotos& camera : cameras) {
      if (any && camera.photo.size() < 3) continue;
      any = ByEventsOfCamera(camera, !any) || any;
    }
    return any;
  }

  // No stamps at all: the order is all there is.
  bool ByCountAlone() {
    if (photos_.size() != event_s_.size() || photos_.empty()) return false;
    for (std::size_t i = 0; i < photos_.size(); ++i) Place(i, event_index_[i], jitter_s_);
    sync_.method = TimeSyncMethod::kEventCount;
    sync_.method_in_words = fmt::format("{} and {} without capture times, paired in order",
                                        Counted(event_s_.size(), "event"), Counted(photos_.size(), "photo"));
    sync_.sigma_s = jitter_s_;
    sync_.notes.emplace_back("the pairing rests on the order of names alone");
    return true;
  }

  bool ByEventsOfCamera(const StampedPhotos& camera, bool is_first) {
    const StampModel model{camera.resolution_s, jitter_s_};
    const std::size_t count = camera.photo.size();
    // As many events as photos, and every difference within one unit: nothing was lost.
    if (count == event_s_.size()) {
      std::vector<double> differences;
      for (std::size_t k = 0; k < count; ++k) differences.push_back(camera.stamp_s[k] - event_s_[k]);
      const auto [least, most] = std::minmax_element(differences.begin(), differences.end());
      if (*most - *least <= model.Spread()) {
        for (std::size_t k = 0; k < count; ++k) Place(camera.photo[k], event_index_[k], jitter_s_);
        if (is_first) {
          SetOffset(FitOffset(differences, model), 0.0);
          sync_.method = TimeSyncMethod::kEventCount;
          sync_.method_in_words = fmt::format("{} for {}, paired in order", Counted(event_s_.size(), "event"),
                                              Counted(count, "photo"));
        }
        return true;
      }
    }
    auto alignment = AlignEvents(camera.stamp_s, event_s_, model);
    if (!alignment) return false;
    // Without a track a photo stands where its event does, and by chance many of another flight's fit too.
    const bool decides_places = log_.gnss.empty() && HasPlacedEvents();
    if (decides_places && 4 * alignment->matched < 3 * std::min(count, event_s_.size())) return false;
    if (!alignment->rivals.empty() && DecideByPositions(camera, *alignment)) {
      alignment->ambiguous_by_s = 0.0;
      sync_.notes.emplace_back("the photos' own positions say which of several shifts it is");
    }
    // A wrong shift would put every photo at the place of its neighbour.
    if (decides_places && alignment->ambiguous_by_s > 0.0) {
      open_by_s_ = alignment->ambiguous_by_s;
      return false;
    }
    const double sigma_s = std::hypot(jitter_s_, alignment->ambiguous_by_s);
    for (std::size_t k = 0; k < count; ++k) {
      if (alignment->event[k]) Place(camera.photo[k], event_index_[*alignment->event[k]], sigma_s);
    }
    if (is_first) {
      std::vector<double> differences;
      for (std::size_t k = 0; k < count; ++k) {
        if (alignment->event[k]) differences.push_back(camera.stamp_s[k] - event_s_[*alignment->event[k]]);
      }
      SetOffset(FitOffset(differences, model), alignment->ambiguous_by_s);
      sync_.method = TimeSyncMethod::kEventPattern;
      sync_.method_in_words =
          fmt::format("{} of {} photos matched to {} events by the pattern of their intervals",
                      alignment->matched, count, event_s_.size());
      if (alignment->ambiguous_by_s > 0.0) {
        sync_.notes.push_back(
            fmt::format("the pattern fits as well {:.2f} s away: the trigger interval hardly varies",
                        alignment->ambiguous_by_s));
      }
    }
    return true;
  }

  bool HasPlacedEvents() const {
    return std::any_of(event_index_.begin(), event_index_.end(),
                       [&](std::size_t i) { return log_.events[i].position.has_value(); });
  }

  // The median distance of the photos' own positions from those of the events that they would be.
  std::optional<double> MedianApartM(const StampedPhotos& camera, const EventOfStamp& event_of) const {
    constexpr std::size_t kEnough = 3;
    std::vector<double> apart_m;
    for (std::size_t k = 0; k < event_of.size(); ++k) {
      const auto& own = photos_[camera.photo[k]].position;
      if (!own || !event_of[k]) continue;
      const auto& there = log_.events[event_index_[*event_of[k]]].position;
      if (there) apart_m.push_back(geo::MetresApart(own->position, *there));
    }
    if (apart_m.size() < kEnough) return std::nullopt;
    return Median(std::move(apart_m));
  }

  // Takes the pairing in which photos lie clearly closest to their events.
  bool DecideByPositions(const StampedPhotos& camera, EventAlignment& alignment) const {
    std::optional<double> nearest_m = MedianApartM(camera, alignment.event), next_m;
    if (!nearest_m) return false;
    EventOfStamp* nearest = &alignment.event;
    for (EventOfStamp& rival : alignment.rivals) {
      const auto apart_m = MedianApartM(camera, rival);
      if (!apart_m) return false;
      if (*apart_m < *nearest_m) {
        next_m = nearest_m;
        nearest_m = apart_m;
        nearest = &rival;
      } else if (!next_m || *apart_m < *next_m) {
        next_m = apart_m;
      }
    }
    constexpr double kClearly = 1.5, kClearlyM = 1.0;
    if (*next_m < kClearly * *nearest_m + kClearlyM) return false;
    if (nearest != &alignment.event) std::swap(alignment.event, *nearest);
    alignment.matched = static_cast<std::size_t>(std::count_if(
        alignment.event.begin(), alignment.event.end(), [](const auto& event) { return event.has_value(); }));
    return true;
  }

  void SetOffset(const OffsetFit& fit, double ambiguous_by_s) {
    sync_.offset_s = -fit.offset_s;
    sync_.sigma_s = std::hypot(std::hypot(fit.sigma_s, 0.005), ambiguous_by_s);
  }

  bool BySearch(const StampedPhotos& camera) {
    auto found = FindClockOffset(photos_, camera, *first_, log_);
    if (!found) {
      why_not_found_ = flight::WhyOf(found.error());
      return false;
    }
    found->photos = std::move(sync_.photos);
    sync_ = *std::move(found);
    return true;
  }

  // Frames of films beside photos have another clock than these, in another zone as a rule: searched for by
  // itself where the photos' puts none of them into the log.
  std::optional<TimeSync> OffsetOfItsOwn(const StampedPhotos& camera, bool is_beside_photos,
                                         const LogCover& cover, const std::vector<double>& times_s) const {
    if (camera.is_of_maker || !is_beside_photos) return std::nullopt;
    const bool is_covered = std::any_of(times_s.begin(), times_s.end(),
                                        [&](double t_s) { return cover.Covers(t_s + sync_.offset_s); });
    if (is_covered) return std::nullopt;
    auto own = FindClockOffset(photos_, camera, *first_, log_);
    return own ? std::optional(*std::move(own)) : std::nullopt;
  }

  // Photos that say where they were, and do not repeat one place, far from where the log was then: of another
  // aircraft, or by a clock that is wrong by itself.
  bool AreElsewhere(const StampedPhotos& camera, const LogCover& cover,
                    const std::vector<double>& times_s) const {
    constexpr std::size_t kEnough = 3;
    constexpr double kElsewhereM = 100.0;  // a receiver's error, and some seconds of flight
    std::vector<double> apart_m;
    std::optional<Eigen::Vector2d> first_m;
    double way_m = 0.0;
    for (std::size_t k = 0; k < times_s.size(); ++k) {
      const std::size_t i = camera.photo[k];
      if (!photos_[i].position || sync_.photos[i]) continue;
      const auto at_m = cover.PositionAt(times_s[k] + sync_.offset_s);
      if (!at_m) continue;
      const Eigen::Vector2d own_m = cover.InPlane(photos_[i].position->position);
      if (!first_m) first_m = own_m;
      way_m = std::max(way_m, (own_m - *first_m).norm());
      apart_m.push_back((own_m - *at_m).norm());
    }
    return apart_m.size() >= kEnough && way_m > kStandsWithinM && Median(std::move(apart_m)) > kElsewhereM;
  }

  // Photos without an event get their stamp moved to the log's clock.
  void FillFromOffset(const std::vector<StampedPhotos>& cameras) {
    const LogCover cover(log_);
    std::ptrdiff_t elsewhere = 0;
    for (const StampedPhotos& camera : cameras) {
      const RefinedStamps refined = RefineByTriggerInterval(camera.stamp_s, camera.resolution_s);
      const auto own = OffsetOfItsOwn(camera, cameras.front().is_of_maker, cover, refined.times_s);
      if (!own && &camera != &cameras.front() && AreElsewhere(camera, cover, refined.times_s)) {
        elsewhere += std::count_if(camera.photo.begin(), camera.photo.end(),
                                   [&](std::size_t i) { return !sync_.photos[i]; });
        continue;
      }
      const double offset_s = own ? own->offset_s : sync_.offset_s;
      const double sigma_s = own ? own->sigma_s : sync_.sigma_s;
      if (own) {
        sync_.notes.push_back(
            fmt::format("{} by a clock of their own: {}",
                        Counted(camera.photo.size(), "picture of no maker is", "pictures of no maker are"),
                        own->method_in_words));
        sync_.warnings.insert(sync_.warnings.end(), own->warnings.begin(), own->warnings.end());
      }
      for (std::size_t k = 0; k < camera.photo.size(); ++k) {
        auto& placed = sync_.photos[camera.photo[k]];
        if (placed) continue;
        placed =
            PhotoTime{refined.times_s[k] + offset_s, std::hypot(refined.sigmas_s[k], sigma_s), std::nullopt};
      }
    }
    if (elsewhere > 0) {
      sync_.notes.push_back(
          fmt::format("{} far from where the log then was, and left to what they record",
                      Counted(elsewhere, "photo of another camera was", "photos of other cameras were")));
    }
    const auto missing = std::count(sync_.photos.begin(), sync_.photos.end(), std::nullopt) - elsewhere;
    if (missing > 0)
      sync_.notes.push_back(fmt::format("{} neither an event nor a capture time",
                                        Counted(missing, "photo has", "photos have")));
  }

  const std::vector<Photo>& photos_;
  const FlightLog& log_;
  TimeSync sync_;
  std::optional<flight::UtcTime> first_;
  std::vector<std::size_t> event_index_;
  std::vector<double> event_s_;
  double jitter_s_ = kFeedbackJitterS;
  std::optional<flight::Remark> why_not_found_;
  double open_by_s_ = 0.0;  // shifts of events by this fit as well, and nothing decides
};

}  // namespace

Result<TimeSync> MatchPhotosToLog(const std::vector<Photo>& photos, const FlightLog& log) {
  if (photos.empty())
    return Error{ErrorCode::kInvalidArgument, "There are no photos to match to the log.", ""};
  return Synchroniser(photos, log).Run();
}

}  // namespace skyquilt::poses
