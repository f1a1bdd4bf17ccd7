// LogBuilder: gathers the samples of a parser, in the order of the file, into a FlightLog that keeps its
// promises: finite numbers, rising times, bounded size. One thread; used once (Finish moves the log out).
//
// Size: a series that reaches its cap is thinned to half and from then on takes every second sample, and so
// on; IMU samples are averaged instead of dropped. At the caps (IMU 8 M samples of 56 bytes, others 2 M) a
// log needs about 0.5 GB at most and usually a few MB. Clock: a step back of more than a second begins a new
// segment (the recorder restarted); the segment with the most samples is kept, the others are named in a
// warning. A single stamp far ahead of its neighbours is dropped. Smaller disorder is sorted away. Of samples
// with the same time and the same payload the first is kept; with different payloads both are dropped.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/flight/logs/flight_log.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

// What lies beyond is no height of an aircraft, or of the ground below it.
inline constexpr double kLowestHeightM = -1e3, kHighestHeightM = 1e5;

// One series with the caps and clock rules above. T has t_s; samples of the IMU are averaged.
template <typename T>
class CappedSeries {
 public:
  explicit CappedSeries(std::size_t cap) : cap_(cap) {}
  // `segment` counts the restarts of the clock seen so far in the whole log.
  void Push(const T& sample, int segment);
  std::vector<T>& samples() { return samples_; }
  const std::vector<T>& samples() const { return samples_; }
  std::uint64_t stride() const { return stride_; }

 private:
  void Halve();
  std::size_t cap_;
  std::uint64_t stride_ = 1;
  std::uint64_t in_group_ = 0;
  T group_{};
  std::vector<T> samples_;
};

class LogBuilder {
 public:
  LogBuilder(std::string format, std::string_view file_name, std::size_t imu_cap = 8'000'000,
             std::size_t other_cap = 2'000'000);

  void Add(const ImuSample& sample);
  void Add(AttitudeSample sample);
  void AddGimbal(AttitudeSample sample);
  void DropGimbal() { gimbal_.samples().clear(); }  // it turned out to hold no camera
  void Add(const GnssSample& sample);  // positions outside the Earth and (0, 0) are dropped and counted
  void Add(const BaroSample& sample);
  void Add(const RangeSample& sample);
  void Add(CameraEvent event);  // at most 200 000

  std::size_t gnss_count() const { return gnss_.samples().size(); }
  std::size_t imu_count() const { return imu_.samples().size(); }
  std::size_t baro_count() const { return baro_.samples().size(); }
  std::size_t event_count() const { return log_.events.size(); }

  // The heights added are above some far zero: subtract the median of the first ten.
  void BaroStartsAtZero() { baro_starts_at_zero_ = true; }
  // A row that cannot be read, of which a last warning tells how many there were. True: it is the first.
  bool SkipRow() { return ++rows_unread_ == 1; }
  void Warn(Remark warning);                                    // at most 100, then a last one says so
  void Count(const std::string& message, std::uint64_t count);  // of at most 1000 kinds; the rest in one
  // What has no clean-up rule: utc_at_zero, mapping, ...
  FlightLog& log() { return log_; }

  FlightLog Finish() &&;
  // Where nothing could be read: kCorrupt, with a remark that names the file alone.
  Error Refuse(RemarkCode why) const;

 private:
  template <typename T>
  void PushTimed(CappedSeries<T>& series, const T& sample, int which);
  void KeepLongestSegment();
  void DropHeightsBeyond(RecordedHeights& heights);
  bool DropHeightsThatAreFillers();
  bool DropTrackHeightsThatAreFillers();
  void DropAnglesThatAreFillers();

  FlightLog log_;
  CappedSeries<ImuSample> imu_;
  CappedSeries<AttitudeSample> attitude_;
  CappedSeries<AttitudeSample> gimbal_;
  CappedSeries<GnssSample> gnss_;
  CappedSeries<BaroSample> baro_;
  CappedSeries<RangeSample> range_;
  struct Clock {
    double last_s = 0.0;
    double before_last_s = 0.0;
    int seen = 0;  // in this segment
  };
  Clock clocks_[6];
  int segment_ = 0;
  std::vector<std::uint64_t> samples_of_segment_{0};
  bool baro_starts_at_zero_ = false;
  std::uint64_t rows_unread_ = 0;
  std::uint64_t not_finite_ = 0;
  std::uint64_t bad_positions_ = 0;
  std::uint64_t stray_stamps_ = 0;
  std::uint64_t events_dropped_ = 0;
  std::uint64_t heights_beyond_ = 0;  // rows
  double first_height_beyond_m_ = 0.0;
};

// The exposure in a row (from 0) of a list that names photos and does not say when they were taken.
CameraEvent EventByName(std::uint64_t row, std::string_view image_name);

// Angles in degrees as a list states them; nothing where one is missing.
std::optional<Eigen::Vector3d> YawPitchRollRad(std::optional<double> yaw_deg, std::optional<double> pitch_deg,
                                               std::optional<double> roll_deg);

// One sigma as a list states it: the vertical one twice the horizontal where it says none.
std::optional<Eigen::Vector3d> SigmaInNedM(std::optional<double> horizontal_m,
                                           std::optional<double> vertical_m);

// Three sigmas; nothing where one is missing or none.
std::optional<Eigen::Vector3d> PositiveSigmas(std::optional<double> first, std::optional<double> second,
                                              std::optional<double> third);

// Z-Y-X angles in radians to the attitude they mean, and back.
Eigen::Quaterniond NedFromYawPitchRoll(double yaw_rad, double pitch_rad, double roll_rad);
Eigen::Vector3d YawPitchRollFromNed(const Eigen::Quaterniond& ned_from_body);

// How a gimbal holds its camera, of what MAVLink and PX4 call its attitude status: by `flags`
// (GIMBAL_DEVICE_FLAGS) yaw counts from north or from the vehicle's heading. Nothing where that is not known.
std::optional<Eigen::Quaterniond> NedFromGimbalDevice(const Eigen::Quaterniond& attitude, unsigned flags,
                                                      const std::optional<double>& heading_rad);

// Height of a pressure in the standard atmosphere, metres (ISA troposphere); differences are what counts.
double StandardHeightM(double pressure_pa);

}  // namespace skyquilt::flight
