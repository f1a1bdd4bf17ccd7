#include "core/poses/time_sync.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/geo/local_frame.h"
#include "core/poses/clock_search.h"
#include "core/poses/event_alignment.h"

namespace skyquilt::poses {
namespace {

using flight::CameraEvent;
using flight::FlightLog;
using flight::Photo;

double SecondsBetween(flight::UtcTime from, flight::UtcTime to) {
  return std::chrono::duration<double>(to - from).count();
}

// Lower case, without folders and extension: "DCIM/IMG_1.JPG" and "img_1.jpg" are one photo.
std::string PlainName(std::string_view name) {
  name = name.substr(name.find_last_of("/\\") + 1);
  if (const auto dot = name.rfind('.'); dot != std::string_view::npos && dot > 0) name = name.substr(0, dot);
  std::string plain(name);
  for (char& c : plain) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return plain;
}

// All stamps of one camera, in order.
struct Stamped {
  std::vector<std::size_t> photo;
  std::vector<double> stamp_s;  // since the first stamp of all
  double resolution_s = 1.0;
};

class Synchroniser {
 public:
  Synchroniser(const std::vector<Photo>& photos, const FlightLog& log, const TimeSyncOptions& options)
      : photos_(photos), log_(log), options_(options) {
    sync_.photos.resize(photos.size());
    for (const Photo& photo : photos) {
      if (photo.captured_at && (!first_ || *photo.captured_at < *first_)) first_ = photo.captured_at;
    }
    const bool any_feedback = std::any_of(log.events.begin(), log.events.end(),
                                          [](const CameraEvent& e) { return e.has_time && e.is_feedback; });
    for (std::size_t i = 0; i < log.events.size(); ++i) {
      const CameraEvent& event = log.events[i];
      if (event.has_time && (event.is_feedback || !any_feedback)) {
        event_index_.push_back(i);
        event_s_.push_back(event.t_s);
      }
    }
    jitter_s_ = any_feedback ? options.trigger_jitter_s : options.command_jitter_s;
  }

  Result<TimeSync> Run() {
    const std::vector<Stamped> cameras = Cameras();
    const bool done = ByNames() || ByEvents(cameras) || (!cameras.empty() && BySearch(cameras.front()));
    if (!done) {
      return Error{
          ErrorCode::kUnprocessable,
          fmt::format(
              "{} photos cannot be tied to {}: give photos with capture times, a log with camera events, or "
              "set the camera's clock",
              photos_.size(), log_.file_name),
          fmt::format("{} events, {} stamped cameras", event_s_.size(), cameras.size())};
    }
    FillFromOffset(cameras);
    if (first_ && log_.utc_at_zero) {
      sync_.camera_ahead_of_utc_s = SecondsBetween(*log_.utc_at_zero, *first_) - sync_.offset_s;
    }
    return std::move(sync_);
  }

 private:
  // The camera with the most stamps comes first.
  std::vector<Stamped> Cameras() const {
    std::map<std::string, Stamped> by_key;
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      if (!photos_[i].captured_at) continue;
      Stamped& camera = by_key[photos_[i].camera_key];
      camera.photo.push_back(i);
      camera.stamp_s.push_back(SecondsBetween(*first_, *photos_[i].captured_at));
    }
    std::vector<Stamped> cameras;
    for (auto& [key, camera] : by_key) {
      if (!std::is_sorted(camera.stamp_s.begin(), camera.stamp_s.end())) {
        std::vector<std::size_t> order(camera.photo.size());
        for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
        std::stable_sort(order.begin(), order.end(),
                         [&](std::size_t a, std::size_t b) { return camera.stamp_s[a] < camera.stamp_s[b]; });
        Stamped sorted;
        for (const std::size_t i : order) {
          sorted.photo.push_back(camera.photo[i]);
          sorted.stamp_s.push_back(camera.stamp_s[i]);
        }
        camera = std::move(sorted);
      }
      camera.resolution_s = ResolutionOf(camera);
      cameras.push_back(std::move(camera));
    }
    std::stable_sort(cameras.begin(), cameras.end(),
                     [](const Stamped& a, const Stamped& b) { return a.photo.size() > b.photo.size(); });
    return cameras;
  }

  // Whole seconds, tenths, hundredths or milliseconds: the coarsest that all stamps keep to.
  double ResolutionOf(const Stamped& camera) const {
    for (const std::int64_t unit_us : {1'000'000, 100'000, 10'000}) {
      const bool all = std::all_of(camera.photo.begin(), camera.photo.end(), [&](std::size_t i) {
        return photos_[i].captured_at->time_since_epoch().count() % unit_us == 0;
      });
      if (all) return static_cast<double>(unit_us) * 1e-6;
    }
    return 1e-3;
  }

  void Place(std::size_t photo, std::size_t event, double sigma_s) {
    sync_.photos[photo] = PhotoTime{log_.events[event].t_s, sigma_s, event};
  }

  // Stamps minus event times of what is matched so far fix the offset.
  void OffsetFromMatches() {
    std::vector<double> differences;
    double resolution = 1e-3;
    for (const Stamped& camera : Cameras()) {
      for (std::size_t k = 0; k < camera.photo.size(); ++k) {
        const auto& placed = sync_.photos[camera.photo[k]];
        if (placed && placed->event) differences.push_back(camera.stamp_s[k] - placed->t_s);
      }
      resolution = std::max(resolution, camera.resolution_s);
    }
    if (differences.empty()) return;
    const OffsetFit fit = FitOffset(differences, {resolution, jitter_s_});
    sync_.offset_s = -fit.offset_s;
    sync_.sigma_s = std::hypot(fit.sigma_s, 0.005);
  }

  bool ByNames() {
    std::map<std::string, std::size_t> events;
    for (std::size_t i = 0; i < log_.events.size(); ++i) {
      const CameraEvent& event = log_.events[i];
      if (event.has_time && event.image_name) events.emplace(PlainName(*event.image_name), i);
    }
    std::size_t matched = 0;
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      const auto found = events.find(PlainName(photos_[i].name));
      if (found == events.end()) continue;
      Place(i, found->second, jitter_s_);
      ++matched;
    }
    if (matched == 0 || 2 * matched < photos_.size()) {
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

  bool ByEvents(const std::vector<Stamped>& cameras) {
    if (event_s_.empty()) return false;
    if (cameras.empty()) return ByCountAlone();
    bool any = false;
    for (const Stamped& camera : cameras) {
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
    sync_.method_in_words = fmt::format("{} events and {} photos without capture times, paired in order",
                                        event_s_.size(), photos_.size());
    sync_.sigma_s = jitter_s_;
    sync_.notes.emplace_back("the pairing rests on the order of names alone");
    return true;
  }

  bool ByEventsOfCamera(const Stamped& camera, bool is_first) {
    const StampModel model{camera.resolution_s, jitter_s_};
    const std::size_t count = camera.photo.size();
    // As many events as photos, and every difference within one unit: nothing was lost.
    if (count == event_s_.size()) {
      std::vector<double> differences;
      for (std::size_t k = 0; k < count; ++k) differences.push_back(camera.stamp_s[k] - event_s_[k]);
      const auto [least, most] = std::minmax_element(differences.begin(), differences.end());
      if (*most - *least <= model.resolution_s + 8.0 * model.jitter_s + 0.05) {
        for (std::size_t k = 0; k < count; ++k) Place(camera.photo[k], event_index_[k], jitter_s_);
        if (is_first) {
          SetOffset(FitOffset(differences, model), 0.0);
          sync_.method = TimeSyncMethod::kEventCount;
          sync_.method_in_words =
              fmt::format("{} events for {} photos, paired in order", event_s_.size(), count);
        }
        return true;
      }
    }
    const auto alignment = AlignEvents(camera.stamp_s, event_s_, model);
    if (!alignment) return false;
    const double sigma_s = std::hypot(jitter_s_, alignment->ambiguous_by_s);
    for (std::size_t k = 0; k < count; ++k) {
      if (alignment->event[k]) Place(camera.photo[k], event_index_[*alignment->event[k]], sigma_s);
    }
    if (is_first) {
      SetOffset(alignment->offset, alignment->ambiguous_by_s);
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

  void SetOffset(const OffsetFit& fit, double ambiguous_by_s) {
    sync_.offset_s = -fit.offset_s;
    sync_.sigma_s = std::hypot(std::hypot(fit.sigma_s, 0.005), ambiguous_by_s);
  }

  bool BySearch(const Stamped& camera) {
    refined_ = RefineByTriggerInterval(camera.stamp_s, camera.resolution_s);
    refined_of_ = camera.photo;
    const std::string stamps =
        refined_->refined > 0
            ? fmt::format("; {} stamps refined by a constant trigger interval", refined_->refined)
            : std::string();
    const std::vector<TrackPoint> track = Track();
    if (!track.empty() && (ByPositions(camera, track, stamps) || ByDistances(camera, track, stamps)))
      return true;
    // Photos that know where they were and fit nowhere on the track belong to another flight: clocks alone
    // must not tie them to this one.
    const auto placed = std::count_if(camera.photo.begin(), camera.photo.end(),
                                      [&](std::size_t i) { return photos_[i].position.has_value(); });
    if (!track.empty() && placed >= 3) return false;
    return ByClocks(stamps);
  }

  std::vector<TrackPoint> Track() {
    std::vector<TrackPoint> track;
    if (log_.gnss.empty()) return track;
    const auto& origin = log_.gnss.front().position;
    frame_.emplace(geo::Wgs84{origin.lat_deg, origin.lon_deg, 0.0});
    track.reserve(log_.gnss.size());
    for (const auto& sample : log_.gnss) track.push_back({sample.t_s, InPlane(sample.position)});
    return track;
  }

  Eigen::Vector2d InPlane(const geo::LatLon& position) const {
    return frame_->EnuFromWgs84({position.lat_deg, position.lon_deg, 0.0}).head<2>();
  }

  bool ByPositions(const Stamped& camera, const std::vector<TrackPoint>& track, const std::string& stamps) {
    std::vector<TimedPosition> timed;
    for (std::size_t k = 0; k < camera.photo.size(); ++k) {
      const Photo& photo = photos_[camera.photo[k]];
      if (photo.position) timed.push_back({refined_->times_s[k], InPlane(photo.position->position)});
    }
    const auto found = SearchByPositions(timed, track);
    // Photos of another flight fit nowhere.
    if (!found || found->residual_m > 50.0) return false;
    sync_.method = TimeSyncMethod::kPositions;
    sync_.offset_s = found->offset_s;
    sync_.sigma_s = std::hypot(found->sigma_s, refined_->common_sigma_s);
    sync_.method_in_words = fmt::format("{} photo positions laid on the log's track, residual {:.2f} m{}",
                                        timed.size(), found->residual_m, stamps);
    return true;
  }

  bool ByDistances(const Stamped& camera, const std::vector<TrackPoint>& track, const std::string& stamps) {
    if (options_.distance_to_next.empty()) return false;
    std::vector<TimedDistance> timed;
    for (std::size_t k = 0; k + 1 < camera.photo.size(); ++k) {
      const std::size_t photo = camera.photo[k];
      if (camera.photo[k + 1] != photo + 1 || photo >= options_.distance_to_next.size()) continue;
      if (const auto distance = options_.distance_to_next[photo]) {
        timed.push_back({refined_->times_s[k], refined_->times_s[k + 1], *distance});
      }
    }
    const auto found = SearchByDistances(timed, track, options_.distances_in_metres);
    if (!found || found->rival_cost_ratio > 0.9) return false;
    sync_.method = TimeSyncMethod::kDistances;
    sync_.offset_s = found->offset_s;
    sync_.sigma_s = std::hypot(found->sigma_s, refined_->common_sigma_s);
    sync_.method_in_words =
        fmt::format("{} distances between photos compared with the log's track{}", timed.size(), stamps);
    return true;
  }

  // Only the clocks as they stand. A local clock may be any whole quarter hour off: the one that puts the
  // photos into the log is taken when it is the only one.
  bool ByClocks(const std::string& stamps) {
    if (!log_.utc_at_zero && !log_.local_at_zero) return false;
    const auto span = LogSpan();
    if (!span || !first_) return false;
    const flight::UtcTime zero = log_.utc_at_zero ? *log_.utc_at_zero : *log_.local_at_zero;
    const double as_it_stands = SecondsBetween(zero, *first_);
    const double last = refined_->times_s.back();
    const bool both_utc = log_.utc_at_zero && !photos_[refined_of_.front()].captured_at_is_local;
    std::vector<double> fitting;
    for (int quarter = -56; quarter <= 56; ++quarter) {
      if (both_utc && quarter != 0) continue;
      const double offset = as_it_stands - quarter * 900.0;
      // A zone is guessed only where it puts all photos into the log; UTC holds for those that lie outside
      // too.
      const bool fits = both_utc ? offset < span->second && offset + last > span->first
                                 : offset > span->first - 5.0 && offset + last < span->second + 5.0;
      if (fits) fitting.push_back(offset);
    }
    if (fitting.empty()) return false;
    const auto nearest = std::min_element(fitting.begin(), fitting.end(), [&](double a, double b) {
      return std::abs(a - as_it_stands) < std::abs(b - as_it_stands);
    });
    sync_.method = TimeSyncMethod::kClocks;
    sync_.offset_s = *nearest;
    sync_.sigma_s = std::hypot(options_.camera_clock_sigma_s, log_.utc_sigma_s);
    if (fitting.size() > 1) sync_.sigma_s = 900.0;
    sync_.method_in_words = fmt::format("the clocks of camera and log as they stand{}", stamps);
    if (!both_utc)
      sync_.notes.emplace_back(
          "the camera's clock is local: the zone that puts the photos into the log was taken");
    if (fitting.size() > 1)
      sync_.notes.push_back(fmt::format("{} time zones would fit the log", fitting.size()));
    return true;
  }

  std::optional<std::pair<double, double>> LogSpan() const {
    std::optional<std::pair<double, double>> span;
    const auto widen = [&](const auto& samples) {
      if (samples.empty()) return;
      if (!span) span.emplace(samples.front().t_s, samples.back().t_s);
      span->first = std::min(span->first, samples.front().t_s);
      span->second = std::max(span->second, samples.back().t_s);
    };
    widen(log_.gnss);
    widen(log_.attitude);
    widen(log_.imu);
    widen(log_.baro);
    if (!event_s_.empty()) widen(log_.events);
    return span;
  }

  // Photos without an event get their stamp moved to the log's clock.
  void FillFromOffset(const std::vector<Stamped>& cameras) {
    for (const Stamped& camera : cameras) {
      const RefinedStamps refined = RefineByTriggerInterval(camera.stamp_s, camera.resolution_s);
      for (std::size_t k = 0; k < camera.photo.size(); ++k) {
        auto& placed = sync_.photos[camera.photo[k]];
        if (placed) continue;
        placed = PhotoTime{refined.times_s[k] + sync_.offset_s,
                           std::hypot(refined.sigmas_s[k], sync_.sigma_s), std::nullopt};
      }
    }
    const auto missing = std::count(sync_.photos.begin(), sync_.photos.end(), std::nullopt);
    if (missing > 0)
      sync_.notes.push_back(fmt::format("{} photos have neither an event nor a capture time", missing));
  }

  const std::vector<Photo>& photos_;
  const FlightLog& log_;
  const TimeSyncOptions& options_;
  TimeSync sync_;
  std::optional<flight::UtcTime> first_;
  std::vector<std::size_t> event_index_;
  std::vector<double> event_s_;
  double jitter_s_ = 0.02;
  std::optional<RefinedStamps> refined_;
  std::vector<std::size_t> refined_of_;
  std::optional<geo::LocalFrame> frame_;
};

}  // namespace

Result<void> TimeSyncOptions::Validate() const {
  const auto positive = [](const char* field, double value) -> Result<void> {
    if (std::isfinite(value) && value > 0.0) return {};
    return Error{ErrorCode::kInvalidArgument, fmt::format("{} is {}, but must be above 0", field, value), ""};
  };
  if (auto r = positive("trigger_jitter_s", trigger_jitter_s); !r) return r;
  if (auto r = positive("command_jitter_s", command_jitter_s); !r) return r;
  return positive("camera_clock_sigma_s", camera_clock_sigma_s);
}

Result<TimeSync> MatchPhotosToLog(const std::vector<Photo>& photos, const FlightLog& log,
                                  const TimeSyncOptions& options) {
  if (auto valid = options.Validate(); !valid) return valid.error();
  if (photos.empty())
    return Error{ErrorCode::kInvalidArgument, "there are no photos to match to the log", ""};
  return Synchroniser(photos, log, options).Run();
}

}  // namespace skyquilt::poses
