#include "core/flight/logs/log_builder.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/base/median.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

// While reading, the segment is kept in the time itself; microseconds survive this in a double.
constexpr double kSegmentStepS = 1e9;
constexpr double kLatestS = 4e8;  // no log lasts 12 years; keeps segments apart
constexpr int kMaxSegments = 64;
constexpr std::size_t kMaxEvents = 200'000;
constexpr std::size_t kMinFlatRows = 3;  // one or two may well be zero

bool IsFinite(const ImuSample& s) {
  return s.angular_rate_radps.allFinite() && s.specific_force_mps2.allFinite();
}
bool IsFinite(const AttitudeSample& s) {
  return s.ned_from_body.coeffs().allFinite() && s.ned_from_body.norm() > 0.5;
}
bool IsFinite(const GnssSample&) { return true; }
bool IsFinite(const BaroSample& s) { return std::isfinite(s.height_above_takeoff_m); }
bool IsFinite(const RangeSample& s) { return std::isfinite(s.distance_m); }

// What was measured, by which two samples of one time are told apart.
auto PayloadOf(const ImuSample& s) { return std::tie(s.angular_rate_radps, s.specific_force_mps2); }
auto PayloadOf(const AttitudeSample& s) { return std::tie(s.ned_from_body.coeffs()); }
auto PayloadOf(const GnssSample& s) {
  return std::tie(s.position.lat_deg, s.position.lon_deg, s.height_amsl_m, s.height_ellipsoid_m);
}
auto PayloadOf(const BaroSample& s) { return std::tie(s.height_above_takeoff_m); }
auto PayloadOf(const RangeSample& s) { return std::tie(s.distance_m); }

void Accumulate(ImuSample& sum, const ImuSample& sample) {
  sum.t_s += sample.t_s;
  sum.angular_rate_radps += sample.angular_rate_radps;
  sum.specific_force_mps2 += sample.specific_force_mps2;
}
void Divide(ImuSample& sum, double by) {
  sum.t_s /= by;
  sum.angular_rate_radps /= by;
  sum.specific_force_mps2 /= by;
}

// Sorts, then drops what stands twice. Returns how many went.
template <typename T>
std::size_t SortAndDropDuplicates(std::vector<T>& samples) {
  const auto earlier = [](const T& a, const T& b) { return a.t_s < b.t_s; };
  if (!std::is_sorted(samples.begin(), samples.end(), earlier)) {
    std::stable_sort(samples.begin(), samples.end(), earlier);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < samples.size();) {
    std::size_t end = i + 1;
    bool same = true;
    while (end < samples.size() && samples[end].t_s == samples[i].t_s) {
      same = same && PayloadOf(samples[i]) == PayloadOf(samples[end]);
      ++end;
    }
    if (end == i + 1 || same) samples[kept++] = samples[i];
    i = end;
  }
  const std::size_t dropped = samples.size() - kept;
  samples.resize(kept);
  return dropped;
}

}  // namespace

template <typename T>
void CappedSeries<T>::Halve() {
  const std::size_t half = samples_.size() / 2;
  for (std::size_t i = 0; i < half; ++i) {
    T merged = samples_[2 * i];
    if constexpr (std::is_same_v<T, ImuSample>) {
      // Samples of two segments are never averaged.
      if (std::abs(samples_[2 * i + 1].t_s - merged.t_s) < 1.0) {
        Accumulate(merged, samples_[2 * i + 1]);
        Divide(merged, 2.0);
      }
    }
    samples_[i] = merged;
  }
  samples_.resize(half);
  stride_ *= 2;
}

template <typename T>
void CappedSeries<T>::Push(const T& sample, int segment) {
  T placed = sample;
  placed.t_s += segment * kSegmentStepS;
  if (samples_.size() >= cap_) Halve();
  if (stride_ == 1) {
    samples_.push_back(placed);
    return;
  }
  if constexpr (std::is_same_v<T, ImuSample>) {
    if (in_group_ > 0 && std::abs(placed.t_s - group_.t_s / static_cast<double>(in_group_)) > 1.0)
      in_group_ = 0;
    if (in_group_ == 0) group_ = T{};
    Accumulate(group_, placed);
    if (++in_group_ == stride_) {
      Divide(group_, static_cast<double>(stride_));
      samples_.push_back(group_);
      in_group_ = 0;
    }
  } else {
    if (in_group_++ == 0) samples_.push_back(placed);
    if (in_group_ == stride_) in_group_ = 0;
  }
}

LogBuilder::LogBuilder(std::string format, std::string_view file_name, std::size_t imu_cap,
                       std::size_t other_cap)
    : imu_(imu_cap),
      attitude_(other_cap),
      gimbal_(other_cap),
      gnss_(other_cap),
      baro_(other_cap),
      range_(other_cap) {
  log_.format = std::move(format);
  log_.file_name = file_name;
}

void LogBuilder::Warn(Remark warning) {
  constexpr std::size_t kMaxWarnings = 100;
  if (log_.warnings.size() < kMaxWarnings) {
    log_.warnings.push_back(std::move(warning));
  } else if (log_.warnings.size() == kMaxWarnings) {
    log_.warnings.emplace_back(RemarkCode::kMoreOfFile);
  }
}

void LogBuilder::Count(const std::string& message, std::uint64_t count) {
  constexpr std::size_t kMaxMessageTypes = 1000;
  const bool has_room =
      log_.message_counts.size() < kMaxMessageTypes || log_.message_counts.contains(message);
  log_.message_counts[has_room ? message : "others"] += count;
}

template <typename T>
void LogBuilder::PushTimed(CappedSeries<T>& series, const T& sample, int which) {
  if (!IsFinite(sample) || !(std::abs(sample.t_s) < kLatestS)) {
    ++not_finite_;
    return;
  }
  Clock& clock = clocks_[which];
  if (clock.seen > 0 && sample.t_s < clock.last_s - 1.0) {
    const bool last_was_stray = clock.seen > 1 && clock.last_s - clock.before_last_s > 60.0 &&
                                sample.t_s >= clock.before_last_s && sample.t_s < clock.before_last_s + 60.0;
    if (last_was_stray && !series.samples().empty() && series.stride() == 1) {
      series.samples().pop_back();
      --samples_of_segment_.back();
      clock.last_s = clock.before_last_s;
      ++stray_stamps_;
    } else if (segment_ + 1 < kMaxSegments) {
      ++segment_;
      samples_of_segment_.push_back(0);
      for (Clock& each : clocks_) each = Clock{};
    }
  }
  clock.before_last_s = clock.last_s;
  clock.last_s = clock.seen == 0 ? sample.t_s : std::max(clock.last_s, sample.t_s);
  ++clock.seen;
  ++samples_of_segment_.back();
  series.Push(sample, segment_);
}

void LogBuilder::Add(const ImuSample& sample) { PushTimed(imu_, sample, 0); }
void LogBuilder::Add(AttitudeSample sample) {
  sample.ned_from_body.normalize();
  PushTimed(attitude_, sample, 1);
}
void LogBuilder::AddGimbal(AttitudeSample sample) {
  sample.ned_from_body.normalize();
  PushTimed(gimbal_, sample, 2);
}

void LogBuilder::Add(const GnssSample& sample) {
  const bool is_null_island =
      std::abs(sample.position.lat_deg) < 1e-6 && std::abs(sample.position.lon_deg) < 1e-6;
  if (is_null_island || !geo::LatLon::Make(sample.position.lat_deg, sample.position.lon_deg)) {
    ++bad_positions_;
    return;
  }
  GnssSample clean = sample;
  const auto keep = [](std::optional<double>& value, double least, double most) {
    if (value && !(*value >= least && *value <= most)) value.reset();
  };
  keep(clean.height_ellipsoid_m, kLowestHeightM, kHighestHeightM);
  keep(clean.height_amsl_m, kLowestHeightM, kHighestHeightM);
  keep(clean.sigma_horizontal_m, 1e-4, 1e4);
  keep(clean.sigma_vertical_m, 1e-4, 1e4);
  if (clean.velocity_in_ned_mps && !clean.velocity_in_ned_mps->allFinite()) clean.velocity_in_ned_mps.reset();
  PushTimed(gnss_, clean, 3);
}

void LogBuilder::Add(const BaroSample& sample) { PushTimed(baro_, sample, 4); }
void LogBuilder::Add(const RangeSample& sample) { PushTimed(range_, sample, 5); }

void LogBuilder::Add(CameraEvent event) {
  if (!(std::abs(event.t_s) < kLatestS)) {
    ++not_finite_;
    return;
  }
  if (log_.events.size() >= kMaxEvents) {
    ++events_dropped_;
    return;
  }
  if (event.position && (!geo::LatLon::Make(event.position->lat_deg, event.position->lon_deg) ||
                         (event.position->lat_deg == 0.0 && event.position->lon_deg == 0.0))) {
    event.position.reset();
  }
  DropHeightsBeyond(event);
  if (event.yaw_pitch_roll_rad && !event.yaw_pitch_roll_rad->allFinite()) event.yaw_pitch_roll_rad.reset();
  if (event.sigma_in_ned_m && !event.sigma_in_ned_m->allFinite()) event.sigma_in_ned_m.reset();
  event.t_s += segment_ * kSegmentStepS;
  log_.events.push_back(std::move(event));
}

// "-9999" and the like are written for heights that are not known; a flight cannot hang on them.
void LogBuilder::DropHeightsBeyond(RecordedHeights& heights) {
  std::optional<double> beyond_m;
  for (std::optional<double>* const height_m :
       {&heights.height_ellipsoid_m, &heights.height_amsl_m, &heights.height_above_takeoff_m,
        &heights.height_above_ground_m}) {
    if (!*height_m || (**height_m >= kLowestHeightM && **height_m <= kHighestHeightM)) continue;
    if (std::isfinite(**height_m)) beyond_m = *height_m;
    height_m->reset();
  }
  if (beyond_m && heights_beyond_++ == 0) first_height_beyond_m_ = *beyond_m;
}

void LogBuilder::KeepLongestSegment() {
  if (segment_ == 0) return;
  const auto longest = std::max_element(samples_of_segment_.begin(), samples_of_segment_.end());
  const auto kept = static_cast<int>(longest - samples_of_segment_.begin());
  const auto keep = [&](auto& samples) {
    std::erase_if(samples, [&](auto& sample) {
      if (std::llround(sample.t_s / kSegmentStepS) != kept) return true;
      sample.t_s -= kept * kSegmentStepS;
      return false;
    });
  };
  ForEachSeries(keep, log_);
  keep(log_.events);
  std::uint64_t total = 0;
  for (const std::uint64_t count : samples_of_segment_) total += count;
  Warn({RemarkCode::kClockJumpedBack,
        {{"jumps", segment_}, {"part", kept + 1}, {"samples", *longest}, {"samples_in_all", total}}});
}

// A column has to stand in lists of photos, and who has no heights fills it with zeros.
bool LogBuilder::DropHeightsThatAreFillers() {
  std::size_t zeros = 0;
  for (const CameraEvent& event : log_.events) {
    if (!event.height_ellipsoid_m && !event.height_amsl_m) continue;
    const bool is_zero =
        event.height_ellipsoid_m.value_or(0.0) == 0.0 && event.height_amsl_m.value_or(0.0) == 0.0;
    if (!is_zero || !event.image_name) return false;
    ++zeros;
  }
  if (zeros < kMinFlatRows) return false;
  for (CameraEvent& event : log_.events) {
    event.height_ellipsoid_m.reset();
    event.height_amsl_m.reset();
  }
  return true;
}

// So do recorders; what is above the ellipsoid may be worked out of that by the geoid.
bool LogBuilder::DropTrackHeightsThatAreFillers() {
  constexpr double kHighestGeoidM = 110.0;
  std::size_t zeros = 0;
  for (const GnssSample& sample : log_.gnss) {
    if (!sample.height_ellipsoid_m && !sample.height_amsl_m) continue;
    const double most_m = sample.height_amsl_m ? kHighestGeoidM : 0.0;
    const bool is_zero = sample.height_amsl_m.value_or(0.0) == 0.0 &&
                         std::abs(sample.height_ellipsoid_m.value_or(0.0)) <= most_m;
    if (!is_zero) return false;
    ++zeros;
  }
  if (zeros < kMinFlatRows) return false;
  for (GnssSample& sample : log_.gnss) {
    sample.height_ellipsoid_m.reset();
    sample.height_amsl_m.reset();
  }
  return true;
}

// So do angles before accuracies; as measured they would turn all cameras to the north.
void LogBuilder::DropAnglesThatAreFillers() {
  std::size_t zeros = 0;
  for (const CameraEvent& event : log_.events) {
    if (!event.yaw_pitch_roll_rad) continue;
    if (!event.yaw_pitch_roll_rad->isZero(0.0) || !event.image_name) return;
    ++zeros;
  }
  if (zeros < kMinFlatRows) return;
  for (CameraEvent& event : log_.events) event.yaw_pitch_roll_rad.reset();
  Warn(RemarkCode::kAnglesNotMeasured);
}

Error LogBuilder::Refuse(RemarkCode why) const {
  return Because(ErrorCode::kCorrupt, {why, {{"file", log_.file_name}}});
}

FlightLog LogBuilder::Finish() && {
  if (rows_unread_ > 0) Warn({RemarkCode::kRowsUnread, {{"rows", rows_unread_}}});
  if (imu_.stride() > 1) Warn({RemarkCode::kImuAveraged, {{"samples", imu_.stride()}}});
  const auto thinned =
      std::max({attitude_.stride(), gnss_.stride(), baro_.stride(), range_.stride(), gimbal_.stride()});
  if (thinned > 1) Warn({RemarkCode::kSeriesThinned, {{"samples", thinned}}});
  log_.imu = std::move(imu_.samples());
  log_.attitude = std::move(attitude_.samples());
  log_.gimbal = std::move(gimbal_.samples());
  log_.gnss = std::move(gnss_.samples());
  log_.baro = std::move(baro_.samples());
  log_.range = std::move(range_.samples());
  KeepLongestSegment();
  std::stable_sort(log_.events.begin(), log_.events.end(),
                   [](const CameraEvent& a, const CameraEvent& b) { return a.t_s < b.t_s; });
  const bool are_of_events = DropHeightsThatAreFillers(), are_of_track = DropTrackHeightsThatAreFillers();
  if (are_of_events || are_of_track) Warn(RemarkCode::kHeightsNotSurveyed);
  DropAnglesThatAreFillers();
  if (heights_beyond_ > 0)
    Warn({RemarkCode::kHeightsBeyond, {{"rows", heights_beyond_}, {"height_m", first_height_beyond_m_}}});
  std::size_t duplicates = 0;
  ForEachSeries([&](auto& samples) { duplicates += SortAndDropDuplicates(samples); }, log_);
  if (duplicates > 0) Warn({RemarkCode::kSamplesOfOneTime, {{"samples", duplicates}}});
  if (not_finite_ > 0) Warn({RemarkCode::kSamplesWithoutNumbers, {{"samples", not_finite_}}});
  if (bad_positions_ > 0) Warn({RemarkCode::kPositionsWithoutFix, {{"positions", bad_positions_}}});
  if (stray_stamps_ > 0) Warn({RemarkCode::kStampsStray, {{"samples", stray_stamps_}}});
  if (events_dropped_ > 0) {
    Warn({RemarkCode::kEventsBeyond, {{"most", kMaxEvents}, {"dropped", events_dropped_}}});
  }
  if (baro_starts_at_zero_ && !log_.baro.empty()) {
    std::vector<double> first;
    for (std::size_t i = 0; i < std::min<std::size_t>(10, log_.baro.size()); ++i) {
      first.push_back(log_.baro[i].height_above_takeoff_m);
    }
    const double zero_m = Median(std::move(first));
    for (BaroSample& sample : log_.baro) sample.height_above_takeoff_m -= zero_m;
  }
  return std::move(log_);
}

std::optional<Eigen::Vector3d> SigmaInNedM(std::optional<double> horizontal_m,
                                           std::optional<double> vertical_m) {
  if (!horizontal_m || !(*horizontal_m > 0.0)) return std::nullopt;
  const bool is_vertical_known = vertical_m && *vertical_m > 0.0;
  return Eigen::Vector3d(*horizontal_m, *horizontal_m, is_vertical_known ? *vertical_m : 2.0 * *horizontal_m);
}

std::optional<Eigen::Vector3d> PositiveSigmas(std::optional<double> first, std::optional<double> second,
                                              std::optional<double> third) {
  // Nothing is below 0.
  if (!(first > 0.0) || !(second > 0.0) || !(third > 0.0)) return std::nullopt;
  return Eigen::Vector3d(*first, *second, *third);
}

std::optional<Eigen::Vector3d> YawPitchRollRad(std::optional<double> yaw_deg, std::optional<double> pitch_deg,
                                               std::optional<double> roll_deg) {
  if (!yaw_deg || !pitch_deg || !roll_deg) return std::nullopt;
  return Eigen::Vector3d(geo::DegToRad(*yaw_deg), geo::DegToRad(*pitch_deg), geo::DegToRad(*roll_deg));
}

CameraEvent EventByName(std::uint64_t row, std::string_view image_name) {
  CameraEvent event;
  event.t_s = static_cast<double>(row);
  event.has_time = false;
  event.image_name = std::string(image_name.substr(0, kMaxNameLength));
  return event;
}

Eigen::Quaterniond NedFromYawPitchRoll(double yaw_rad, double pitch_rad, double roll_rad) {
  return Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX());
}

Eigen::Vector3d YawPitchRollFromNed(const Eigen::Quaterniond& ned_from_body) {
  const Eigen::Matrix3d r = ned_from_body.normalized().toRotationMatrix();
  const double pitch_rad = std::asin(std::clamp(-r(2, 0), -1.0, 1.0));
  if (std::abs(r(2, 0)) > 1.0 - 1e-12) {  // straight up or down: only yaw and roll together are known
    return {std::atan2(-r(0, 1), r(1, 1)), pitch_rad, 0.0};
  }
  return {std::atan2(r(1, 0), r(0, 0)), pitch_rad, std::atan2(r(2, 1), r(2, 2))};
}

std::optional<Eigen::Quaterniond> NedFromGimbalDevice(const Eigen::Quaterniond& attitude, unsigned flags,
                                                      const std::optional<double>& heading_rad) {
  constexpr unsigned kYawLock = 16, kYawInVehicleFrame = 32, kYawInEarthFrame = 64;
  if (!(attitude.norm() > 0.5)) return std::nullopt;
  const bool says_frame = (flags & (kYawInVehicleFrame | kYawInEarthFrame)) != 0;
  if ((flags & (says_frame ? kYawInEarthFrame : kYawLock)) != 0) return attitude;
  if (!heading_rad) return std::nullopt;
  return NedFromYawPitchRoll(*heading_rad, 0.0, 0.0) * attitude;
}

double StandardHeightM(double pressure_pa) {
  return 44330.76923 * (1.0 - std::pow(std::max(pressure_pa, 1.0) / 101325.0, 0.190263));
}

}  // namespace skyquilt::flight
