#include "core/poses/time/find_clock_offset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geo/local_frame.h"
#include "core/poses/time/clock_search.h"
#include "core/poses/time/event_alignment.h"

namespace skyquilt::poses {
namespace {

using flight::FlightLog;
using flight::Photo;

// Of a camera's clock that claims UTC and is not checked by anything.
constexpr double kCameraClockSigmaS = 2.0;

class OffsetSearch {
 public:
  OffsetSearch(const std::vector<Photo>& photos, const StampedPhotos& camera, flight::UtcTime first,
               const FlightLog& log)
      : photos_(photos),
        camera_(camera),
        first_(first),
        log_(log),
        refined_(RefineByTriggerInterval(camera.stamp_s, camera.resolution_s)) {
    if (refined_.refined > 0)
      stamps_ = fmt::format("; {} stamps refined by a constant trigger interval", refined_.refined);
    MakeTrack();
  }

  std::optional<FoundOffset> Run() {
    if (!track_.empty() && ByPositions()) return found_;
    // Photos that know where they were and fit nowhere on the track belong to another flight: clocks alone
    // must not tie them to this one.
    const auto placed = std::count_if(camera_.photo.begin(), camera_.photo.end(),
                                      [&](std::size_t i) { return photos_[i].position.has_value(); });
    if (!track_.empty() && placed >= 3) return std::nullopt;
    if (!ByClocks()) return std::nullopt;
    return found_;
  }

 private:
  void MakeTrack() {
    if (log_.gnss.empty()) return;
    const auto& origin = log_.gnss.front().position;
    frame_.emplace(geo::Wgs84{origin.lat_deg, origin.lon_deg, 0.0});
    track_.reserve(log_.gnss.size());
    for (const auto& sample : log_.gnss) track_.push_back({sample.t_s, InPlane(sample.position)});
  }

  Eigen::Vector2d InPlane(const geo::LatLon& position) const {
    return frame_->EnuFromWgs84({position.lat_deg, position.lon_deg, 0.0}).head<2>();
  }

  bool ByPositions() {
    std::vector<TimedPosition> timed;
    for (std::size_t k = 0; k < camera_.photo.size(); ++k) {
      const Photo& photo = photos_[camera_.photo[k]];
      if (photo.position) timed.push_back({refined_.times_s[k], InPlane(photo.position->position)});
    }
    const auto found = SearchByPositions(timed, track_);
    // Photos of another flight fit nowhere.
    if (!found || found->residual_m > 50.0) return false;
    found_.method = TimeSyncMethod::kPositions;
    found_.offset_s = found->offset_s;
    found_.sigma_s = std::hypot(found->sigma_s, refined_.common_sigma_s);
    found_.method_in_words = fmt::format("{} photo positions fitted to the log's track, residual {:.2f} m{}",
                                         timed.size(), found->residual_m, stamps_);
    return true;
  }

  // Only the clocks as they stand. A local clock may be any whole quarter hour off: the one that puts the
  // photos into the log is taken when it is the only one.
  bool ByClocks() {
    if (!log_.utc_at_zero && !log_.local_at_zero) return false;
    const auto span = LogSpan();
    if (!span) return false;
    const flight::UtcTime zero = log_.utc_at_zero ? *log_.utc_at_zero : *log_.local_at_zero;
    const double as_it_stands = SecondsBetween(zero, first_);
    const double last = refined_.times_s.back();
    const bool both_utc = log_.utc_at_zero && !photos_[camera_.photo.front()].captured_at_is_local;
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
    found_.method = TimeSyncMethod::kClocks;
    found_.offset_s = *nearest;
    found_.sigma_s = std::hypot(kCameraClockSigmaS, log_.utc_sigma_s);
    if (fitting.size() > 1) found_.sigma_s = 900.0;
    found_.method_in_words = fmt::format("the clocks of camera and log as they stand{}", stamps_);
    if (!both_utc)
      found_.notes.emplace_back(
          "the camera's clock is local: the zone that puts the photos into the log was taken");
    if (fitting.size() > 1)
      found_.notes.push_back(fmt::format("{} time zones would fit the log", fitting.size()));
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
    const bool any_timed = std::any_of(log_.events.begin(), log_.events.end(),
                                       [](const flight::CameraEvent& event) { return event.has_time; });
    if (any_timed) widen(log_.events);
    return span;
  }

  const std::vector<Photo>& photos_;
  const StampedPhotos& camera_;
  flight::UtcTime first_;
  const FlightLog& log_;
  RefinedStamps refined_;
  std::string stamps_;  // what was done to them, in words
  std::optional<geo::LocalFrame> frame_;
  std::vector<TrackPoint> track_;
  FoundOffset found_;
};

}  // namespace

std::optional<FoundOffset> FindClockOffset(const std::vector<Photo>& photos, const StampedPhotos& camera,
                                           flight::UtcTime first, const FlightLog& log) {
  return OffsetSearch(photos, camera, first, log).Run();
}

}  // namespace skyquilt::poses
