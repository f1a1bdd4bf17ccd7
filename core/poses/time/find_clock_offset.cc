#include "core/poses/time/find_clock_offset.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "core/base/median.h"
#include "core/base/text/printable.h"
#include "core/flight/remarks/because.h"
#include "core/poses/log_span.h"
#include "core/poses/time/clock_zone.h"
#include "core/poses/time/event_alignment.h"
#include "core/poses/time/log_cover.h"

namespace skyquilt::poses {
namespace {

using flight::FlightLog;
using flight::Photo;
using flight::RemarkCode;

// Of a track without fixes; of slow ones two of their intervals.
constexpr double kLongestGapS = 2.0, kGapIntervals = 2.0;
constexpr double kCoarseStepS = 0.5;
constexpr double kOnTrackM = 15.0;  // two plain receivers apart, and a wrong second
constexpr std::size_t kMaxSteps = 200'000;
constexpr std::size_t kMaxPhotosCoarse = 150;

struct ClockOffset {
  double offset_s = 0.0;  // add to the photo's time to get the log's
  double sigma_s = 0.0;
  double residual_m = 0.0;  // robust, of one photo
  double cost = 0.0;        // a photo, of all of them
  std::size_t on_track = 0;
};

// Of a track on the log's clock, of photos on the camera's; in one local plane.
struct TimedPosition {
  double t_s = 0.0;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
};

// Errors of all photos at an offset (infinite where off the track).
using ErrorsAt = std::function<void(double offset_s, std::size_t stride, std::vector<double>& errors)>;

// Cauchy cost per photo; those off the track cost as much as a gross error. A metre is a receiver's noise.
double CostOf(const std::vector<double>& errors) {
  double sum = 0.0;
  for (const double error : errors) {
    const double z = std::isfinite(error) ? error : 100.0;
    sum += std::log1p(std::min(z * z, 1e4));
  }
  return sum / static_cast<double>(errors.size());
}

struct Range {
  double from_s;
  double to_s;
};

std::optional<ClockOffset> Search(const ErrorsAt& errors_at, std::size_t count, Range range) {
  if (!(range.to_s >= range.from_s)) return std::nullopt;
  const double step = std::max(kCoarseStepS, (range.to_s - range.from_s) / static_cast<double>(kMaxSteps));
  const std::size_t stride = std::max<std::size_t>(1, count / kMaxPhotosCoarse);
  const auto steps = static_cast<std::size_t>((range.to_s - range.from_s) / step) + 1;
  std::vector<double> errors;
  std::vector<double> costs(steps);
  for (std::size_t k = 0; k < steps; ++k) {
    errors_at(range.from_s + step * static_cast<double>(k), stride, errors);
    costs[k] = CostOf(errors);
  }
  const auto best = static_cast<std::size_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  ClockOffset found;
  // Narrowing grids around the minimum.
  double middle = range.from_s + step * static_cast<double>(best);
  double reach = 2.0 * step;
  while (reach > 2e-3) {
    double at = middle;
    double lowest = std::numeric_limits<double>::infinity();
    for (int k = -10; k <= 10; ++k) {
      const double offset = middle + reach * k / 10.0;
      errors_at(offset, 1, errors);
      const double cost = CostOf(errors);
      if (cost < lowest) {
        lowest = cost;
        at = offset;
      }
    }
    middle = at;
    reach *= 0.2;
  }
  found.offset_s = middle;
  errors_at(middle, 1, errors);
  std::vector<double> sizes;
  for (const double error : errors) {
    if (std::isfinite(error)) sizes.push_back(std::abs(error));
  }
  if (sizes.empty()) return std::nullopt;
  found.cost = CostOf(errors);
  found.on_track = sizes.size();
  found.residual_m = Median(sizes);
  return found;
}

// Where the log was.
struct Track {
  std::vector<TimedPosition> points;
  double longest_gap_s = kLongestGapS;

  // Position at a time; nothing outside the track and in its gaps.
  std::optional<Eigen::Vector2d> At(double t_s) const {
    const auto after = std::lower_bound(points.begin(), points.end(), t_s,
                                        [](const TimedPosition& point, double t) { return point.t_s < t; });
    if (after == points.end()) return std::nullopt;
    if (after->t_s == t_s) return after->position_m;
    if (after == points.begin()) return std::nullopt;
    const auto before = after - 1;
    const double gap_s = after->t_s - before->t_s;
    if (gap_s > longest_gap_s) return std::nullopt;
    const double share = (t_s - before->t_s) / gap_s;
    return before->position_m + share * (after->position_m - before->position_m);
  }
};

// Every offset in the range is tried.
std::optional<ClockOffset> SearchByPositions(std::span<const TimedPosition> photos, const Track& track,
                                             Range range) {
  const auto errors_at = [&](double offset, std::size_t stride, std::vector<double>& errors) {
    errors.clear();
    for (std::size_t i = 0; i < photos.size(); i += stride) {
      const auto position = track.At(photos[i].t_s + offset);
      errors.push_back(position ? (*position - photos[i].position_m).norm()
                                : std::numeric_limits<double>::infinity());
    }
  };
  auto found = Search(errors_at, photos.size(), range);
  if (!found) return std::nullopt;
  // Along-track errors over the sum of squared speeds; of one receiver they err together for seconds.
  double speeds = 0.0, along = 0.0;
  std::size_t used = 0;
  for (const TimedPosition& photo : photos) {
    const auto before = track.At(photo.t_s + found->offset_s - 0.25);
    const auto at = track.At(photo.t_s + found->offset_s);
    const auto after = track.At(photo.t_s + found->offset_s + 0.25);
    if (!before || !at || !after) continue;
    const Eigen::Vector2d velocity = (*after - *before) / 0.5;
    const Eigen::Vector2d error = photo.position_m - *at;
    if (error.norm() > 10.0 * found->residual_m + 1.0) continue;
    speeds += velocity.squaredNorm();
    if (velocity.norm() > 0.5) along += std::pow(error.dot(velocity.normalized()), 2);
    ++used;
  }
  if (used < 4 || speeds < 1.0) return std::nullopt;
  const double correlated = 3.0;
  found->sigma_s = std::sqrt(correlated * (along / static_cast<double>(used) + 0.01) / speeds);
  return found;
}

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
        cover_(log),
        refined_(RefineByTriggerInterval(camera.stamp_s, camera.resolution_s)) {
    if (refined_.refined > 0)
      stamps_ = fmt::format("; {} stamps refined by a constant trigger interval", refined_.refined);
    track_.longest_gap_s = std::max(kLongestGapS, kGapIntervals * UsualIntervalS(log.gnss));
    for (const auto& sample : log.gnss)
      track_.points.push_back({sample.t_s, cover_.InPlane(sample.position)});
  }

  Result<TimeSync> Run() {
    if (!track_.points.empty() && ByPositions()) return found_;
    // Photos that know where they were and fit nowhere on the track belong to another flight: clocks alone
    // must not tie them to this one.
    const auto placed = std::count_if(camera_.photo.begin(), camera_.photo.end(),
                                      [&](std::size_t i) { return photos_[i].position.has_value(); });
    if (!track_.points.empty() && placed >= 3) return NotTied(RemarkCode::kNotTiedByPositions);
    if (!log_.utc_at_zero && !log_.local_at_zero) return NotTied(RemarkCode::kNotTiedWithoutDate);
    if (!ByClocks()) return NotTied(SpansApart());
    return found_;
  }

 private:
  bool ByPositions() {
    std::vector<TimedPosition> timed;
    for (std::size_t k = 0; k < camera_.photo.size(); ++k) {
      const Photo& photo = photos_[camera_.photo[k]];
      if (photo.position) timed.push_back({refined_.times_s[k], cover_.InPlane(photo.position->position)});
    }
    if (timed.size() < 4 || track_.points.size() < 4) return false;
    // Every offset that keeps four fifths of the photos on the track is tried.
    const std::size_t spare = timed.size() / 5;
    auto found = SearchByPositions(timed, track_,
                                   {track_.points.front().t_s - timed[spare].t_s,
                                    track_.points.back().t_s - timed[timed.size() - 1 - spare].t_s});
    if (!found || found->on_track < timed.size() || found->residual_m > kOnTrackM) {
      const auto part = PartByClocks(timed);
      if (part && (!found || part->cost < found->cost)) found = part;
    }
    // Photos of another flight fit nowhere.
    if (!found || found->residual_m > 50.0) return false;
    found_.method = TimeSyncMethod::kPositions;
    found_.offset_s = found->offset_s;
    found_.sigma_s = std::hypot(found->sigma_s, refined_.common_sigma_s);
    found_.method_in_words = fmt::format("{} photo positions fitted to the log's track, residual {:.2f} m{}",
                                         timed.size(), found->residual_m, stamps_);
    return true;
  }

  // Where the log covers most of the photos, and others go on beyond it: with the clocks as they stand, give
  // or take some minutes, or whole hours off.
  std::optional<ClockOffset> PartByClocks(std::span<const TimedPosition> timed) const {
    constexpr int kWidestZoneH = 14;
    constexpr double kHourS = 3600.0, kMinutesOffS = 1800.0, kSecondsOffS = 60.0;
    if (!log_.utc_at_zero && !log_.local_at_zero) return std::nullopt;
    std::optional<ClockOffset> best;
    for (int hours = -kWidestZoneH; hours <= kWidestZoneH; ++hours) {
      const double middle_s = flight::SecondsBetween(ZeroOfLog(), first_) + kHourS * hours;
      const double reach_s = hours == 0 ? kMinutesOffS : kSecondsOffS;
      const auto found = SearchByPositions(timed, track_, {middle_s - reach_s, middle_s + reach_s});
      if (!found || found->residual_m > kOnTrackM || 2 * found->on_track <= timed.size()) continue;
      if ((!best || found->cost < best->cost) && cover_.PhotosRunOn(TimesAt(found->offset_s))) best = found;
    }
    return best;
  }

  std::vector<double> TimesAt(double offset_s) const {
    std::vector<double> times_s = refined_.times_s;
    for (double& t_s : times_s) t_s += offset_s;
    return times_s;
  }

  // The clocks as they stand, where both know UTC.
  bool ByUtc(double as_it_stands_s) {
    found_.offset_s = as_it_stands_s;
    const std::vector<double> times_s = TimesAt(as_it_stands_s);
    const auto covered = static_cast<std::size_t>(
        std::count_if(times_s.begin(), times_s.end(), [&](double t_s) { return cover_.Covers(t_s); }));
    if (covered == 0) return false;
    SayCovered(covered);
    constexpr double kNearlyAll = 0.9;
    if (static_cast<double>(covered) < kNearlyAll * static_cast<double>(times_s.size()) &&
        !cover_.AreOthersOfGround(times_s) && !cover_.IsCutWhereItLacks(times_s)) {
      found_.warnings.push_back(
          {RemarkCode::kPhotosBeyondLog,
           {{"file", log_.file_name}, {"outside", times_s.size() - covered}, {"photos", times_s.size()}}});
    }
    return true;
  }

  // Where photos name their zone, and the log contradicts it: by it the aircraft stood still while they were
  // taken, or their headings or spacing say another. What a receiver told is no zone's mistake. Photos of
  // other cameras move with these: none of them may tell its time otherwise, or have flown by it.
  std::optional<ZoneChoice> ZoneInsteadOfWritten(double as_it_stands_s) const {
    constexpr std::size_t kNearlyAll = 9, kOf = 10;
    constexpr int kHalfHourMin = 30;
    const auto written = photos_[camera_.photo.front()].clock_minus_utc;
    if (!written || !cover_.HasTrack()) return std::nullopt;
    std::vector<double> all_s;  // of all cameras
    for (const Photo& photo : photos_) {
      if (!photo.captured_at) continue;
      if (photo.receiver_time || photo.receiver_time_of_day || photo.clock_minus_utc != written)
        return std::nullopt;
      all_s.push_back(flight::SecondsBetween(first_, *photo.captured_at) + as_it_stands_s);
    }
    const auto are_nearly_all = [&](std::size_t covered) {
      return kOf * covered >= kNearlyAll * camera_.photo.size();
    };
    const std::vector<double> times_s = TimesAt(as_it_stands_s);
    if (!are_nearly_all(static_cast<std::size_t>(
            std::count_if(times_s.begin(), times_s.end(), [&](double t_s) { return cover_.Covers(t_s); }))))
      return std::nullopt;
    auto zone = ChooseZone(photos_, camera_, refined_.times_s, as_it_stands_s, log_);
    if (!zone || zone->zone_min == 0 || zone->zone_min % kHalfHourMin != 0 ||
        !are_nearly_all(zone->covered) || cover_.WayM(TimesAt(zone->offset_s)) <= kStandsWithinM)
      return std::nullopt;
    const bool stood = cover_.WayM(all_s) <= kStandsWithinM;
    const bool is_decided = !zone->decided_by.empty() && zone->open_with_min.empty();
    return stood || is_decided ? zone : std::nullopt;
  }

  void TakeInsteadOfWritten(const ZoneChoice& zone) {
    const auto written_min = static_cast<int>(photos_[camera_.photo.front()].clock_minus_utc->count());
    found_.offset_s = zone.offset_s;
    if (!zone.open_with_min.empty()) found_.sigma_s = kOpenClockSigmaS;
    SayCovered(zone.covered);
    found_.warnings.push_back({RemarkCode::kWrittenZoneRefuted,
                               {{"file", log_.file_name},
                                {"zone", "UTC" + ZoneInWords(written_min)},
                                {"other", "UTC" + ZoneInWords(written_min + zone.zone_min)}}});
  }

  void SayCovered(std::size_t covered) {
    if (covered == refined_.times_s.size()) return;
    found_.notes.push_back(
        fmt::format("the log covers {} of {}", covered, Counted(refined_.times_s.size(), "photo")));
  }

  // Only the clocks as they stand: UTC, or a camera's clock in whatever zone puts the photos into the log.
  bool ByClocks() {
    const double as_it_stands = flight::SecondsBetween(ZeroOfLog(), first_);
    found_.method = TimeSyncMethod::kClocks;
    found_.sigma_s = std::hypot(kCameraClockSigmaS, log_.utc_sigma_s);
    found_.method_in_words = fmt::format("the clocks of camera and log as they stand{}", stamps_);
    if (log_.utc_at_zero && !photos_[camera_.photo.front()].captured_at_is_local) {
      const auto instead = ZoneInsteadOfWritten(as_it_stands);
      if (!instead) return ByUtc(as_it_stands);
      TakeInsteadOfWritten(*instead);
      return true;
    }
    const auto zone = ChooseZone(photos_, camera_, refined_.times_s, as_it_stands, log_);
    if (!zone) return false;
    found_.offset_s = zone->offset_s;
    found_.notes.emplace_back(
        "the camera's clock is local: the zone that puts the photos into the log was taken");
    SayCovered(zone->covered);
    if (zone->fitting > 1)
      found_.notes.push_back(fmt::format("{} time zones would fit the log", zone->fitting));
    if (!zone->decided_by.empty()) found_.notes.push_back(zone->decided_by + " which of them it is");
    if (!zone->open_with_min.empty()) LeaveOpen(*zone);
    return true;
  }

  void LeaveOpen(const ZoneChoice& zone) {
    found_.sigma_s = kOpenClockSigmaS;
    std::string others;
    for (const int other_min : zone.open_with_min)
      others += fmt::format("{}UTC{}", others.empty() ? "" : ", ", ZoneInWords(other_min));
    found_.warnings.push_back({RemarkCode::kZoneOpen,
                               {{"file", log_.file_name},
                                {"zone", "UTC" + ZoneInWords(zone.zone_min)},
                                {"others", std::move(others)}}});
  }

  flight::UtcTime ZeroOfLog() const { return log_.utc_at_zero ? *log_.utc_at_zero : *log_.local_at_zero; }

  // When the photos were taken, and when the log was written.
  flight::Remark SpansApart() const {
    const auto at = [](flight::UtcTime zero, double s) { return DateInWords(flight::LaterBy(zero, s)); };
    if (cover_.IsEmpty()) return RemarkCode::kNotTiedNoEvents;
    return {RemarkCode::kNotTiedByClocks,
            {{"taken_from", at(first_, camera_.stamp_s.front())},
             {"taken_until", at(first_, camera_.stamp_s.back())},
             {"log_from", at(ZeroOfLog(), cover_.stretches().front().begin_s)},
             {"log_until", at(ZeroOfLog(), cover_.stretches().back().end_s)}}};
  }

  Error NotTied(flight::Remark why) const {
    why.values.emplace("photos", photos_.size());
    why.values.emplace("file", log_.file_name);
    if (why.code != RemarkCode::kNotTiedByClocks) why.values.emplace("positions", log_.gnss.size());
    return flight::Because(ErrorCode::kUnprocessable, std::move(why));
  }

  const std::vector<Photo>& photos_;
  const StampedPhotos& camera_;
  flight::UtcTime first_;
  const FlightLog& log_;
  LogCover cover_;
  RefinedStamps refined_;
  std::string stamps_;  // what was done to them, in words
  Track track_;
  TimeSync found_;
};

}  // namespace

Result<TimeSync> FindClockOffset(const std::vector<Photo>& photos, const StampedPhotos& camera,
                                 flight::UtcTime first, const FlightLog& log) {
  return OffsetSearch(photos, camera, first, log).Run();
}

}  // namespace skyquilt::poses
