#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "core/flight/bytes/gps_time.h"
#include "core/flight/logs/autopilots/dataflash_plan.h"
#include "core/flight/logs/autopilots/dataflash_walk.h"
#include "core/flight/logs/formats.h"
#include "core/flight/logs/log_builder.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::flight {
namespace {

using geo::DegToRad;

using Kind = DataflashKind;
using Plan = DataflashPlan;
using Census = DataflashCensus;
using Plans = std::array<Plan, 256>;

constexpr std::size_t kMaxWaiting = 4096;
constexpr double kLongestGapS = 0.05;  // accelerometer samples further apart are not joined

// Recorders that log gyroscope and accelerometer apart, each at its own times, give one IMU series: at every
// gyroscope sample, with the accelerometer interpolated between its neighbours.
class RawImuPairing {
 public:
  explicit RawImuPairing(LogBuilder& builder) : builder_(builder) {}

  void AddGyro(double t_s, const Eigen::Vector3d& angular_rate_radps) {
    if (gyro_.size() == kMaxWaiting) gyro_.pop_front();
    gyro_.push_back({t_s, angular_rate_radps});
  }
  void AddAccel(double t_s, const Eigen::Vector3d& specific_force_mps2) {
    while (accel_ && !gyro_.empty() && gyro_.front().t_s <= t_s) {
      const Reading gyro = gyro_.front();
      gyro_.pop_front();
      const double gap = t_s - accel_->t_s;
      if (gyro.t_s < accel_->t_s || gap > kLongestGapS) continue;
      const double share = gap > 0.0 ? (gyro.t_s - accel_->t_s) / gap : 1.0;
      builder_.Add(
          ImuSample{gyro.t_s, gyro.value, accel_->value + share * (specific_force_mps2 - accel_->value)});
    }
    accel_ = Reading{t_s, specific_force_mps2};
  }

 private:
  struct Reading {
    double t_s;
    Eigen::Vector3d value;
  };
  LogBuilder& builder_;
  std::deque<Reading> gyro_;  // later than the last accelerometer sample
  std::optional<Reading> accel_;
};

class DataflashReader {
 public:
  DataflashReader(const Census& census, LogBuilder& builder)
      : builder_(builder),
        imu_(std::max(census.BestImu(), 0)),
        uses_raw_imu_(census.HasRawImu(imu_)),
        raw_imu_(builder),
        gps_(census.BestGps()),
        baro_(census.First(Kind::kBaro)),
        attitude_rank_(census.First(Kind::kAttitude)),
        mount_(census.First(Kind::kMount)),
        camera_rank_(census.First(Kind::kCamera)),
        has_gps_(!census.gps_quality.empty() && census.gps_quality.at(gps_) > 0.0),
        has_trigger_(census.Of(Kind::kCamera).size() > 1) {}

  void Take(const Plan& plan, const std::uint8_t* payload) {
    switch (plan.meaning.kind) {
      case Kind::kImu:
        TakeImu(plan, payload);
        break;
      case Kind::kRawGyro:
      case Kind::kRawAccel:
        TakeRawImu(plan, payload);
        break;
      case Kind::kGps:
        TakeGps(plan, payload);
        break;
      case Kind::kGpa:
        if (gnss_ && plan.Instance(payload) == gps_ && std::abs(plan.TimeS(payload) - gnss_->t_s) < 0.15) {
          gnss_->sigma_horizontal_m = plan.Get(0, payload);
          gnss_->sigma_vertical_m = plan.Get(1, payload);
        }
        break;
      case Kind::kBaro:
        if (plan.f[0] != nullptr && plan.Instance(payload) == baro_) {
          builder_.Add(BaroSample{plan.TimeS(payload), plan.Number(0, payload)});
        }
        break;
      case Kind::kRange:
        TakeRange(plan, payload);
        break;
      case Kind::kPosition:
        TakePosition(plan, payload);
        break;
      case Kind::kAttitude:
        TakeAttitude(plan, payload);
        break;
      case Kind::kMount:
        TakeMount(plan, payload);
        break;
      case Kind::kCamera:
        TakeCamera(plan, payload);
        break;
      default:
        break;
    }
  }

  void Finish() {
    // As of one that is set up and never driven: a camera fixed to the airframe looks down.
    if (!has_mount_looked_down_) builder_.DropGimbal();
    FlushGnss();
    const auto fit = clock_.Solve();
    if (fit) {
      builder_.log().utc_at_zero = fit->utc_at_zero;
      // The receiver reports 0.05 to 0.25 s late, which the scatter does not show.
      builder_.log().utc_sigma_s = std::hypot(0.15, fit->scatter_s);
    }
    for (auto& [event, utc] : events_without_time_) {
      if (fit) {
        event.t_s = SecondsBetween(fit->utc_at_zero, utc);
        builder_.Add(event);
      }
    }
    if (!fit && !events_without_time_.empty()) builder_.Warn(RemarkCode::kEventsWithoutTime);
    if (!has_gps_ && builder_.gnss_count() > 0) {
      builder_.Warn(RemarkCode::kPositionsOfAutopilot);
    }
  }

  int imu() const { return imu_; }

 private:
  void TakeImu(const Plan& plan, const std::uint8_t* payload) {
    if (uses_raw_imu_ || !plan.Has(0, 5) || plan.Instance(payload) != imu_) return;
    builder_.Add(ImuSample{plan.TimeS(payload), plan.Vector(0, payload), plan.Vector(3, payload)});
  }

  void TakeRawImu(const Plan& plan, const std::uint8_t* payload) {
    if (!uses_raw_imu_ || !plan.Has(0, 2) || plan.Instance(payload) != imu_) return;
    if (plan.meaning.kind == Kind::kRawGyro)
      raw_imu_.AddGyro(plan.TimeS(payload), plan.Vector(0, payload));
    else
      raw_imu_.AddAccel(plan.TimeS(payload), plan.Vector(0, payload));
  }

  static std::optional<UtcTime> UtcOf(std::optional<double> tow_ms, std::optional<double> week) {
    return tow_ms && week ? UtcFromGpsWeek(std::llround(*week), std::llround(*tow_ms * 1e3)) : std::nullopt;
  }

  void FlushGnss() {
    if (gnss_) builder_.Add(*gnss_);
    gnss_.reset();
  }

  void TakeGps(const Plan& plan, const std::uint8_t* payload) {
    if (plan.Instance(payload) != gps_ || !plan.Has(3, 4)) return;
    const double status = plan.Get(0, payload).value_or(3.0);
    const double t_s = plan.TimeS(payload);
    if (status < 3.0) return;
    if (const auto utc = UtcOf(plan.Get(1, payload), plan.Get(2, payload))) clock_.Add(t_s, *utc);
    FlushGnss();
    GnssSample sample;
    sample.t_s = t_s;
    sample.position = {plan.Number(3, payload), plan.Number(4, payload)};
    sample.height_amsl_m = plan.Get(5, payload);
    const auto speed = plan.Get(6, payload);
    const auto course = plan.Get(7, payload);
    if (speed && course) {
      const double course_rad = DegToRad(*course);
      sample.velocity_in_ned_mps = Eigen::Vector3d(
          *speed * std::cos(course_rad), *speed * std::sin(course_rad), plan.Get(8, payload).value_or(0.0));
    }
    sample.is_rtk_fixed = status >= 6.0;
    gnss_ = sample;
  }

  void TakeRange(const Plan& plan, const std::uint8_t* payload) {
    constexpr double kDown = 25.0;  // MAV_SENSOR_ROTATION_PITCH_270
    constexpr double kGood = 4.0;
    const auto distance = plan.Get(0, payload);
    if (!distance || *distance <= 0.0) return;
    if (plan.Get(1, payload).value_or(kDown) != kDown || plan.Get(2, payload).value_or(kGood) < kGood) return;
    builder_.Add(RangeSample{plan.TimeS(payload), *distance});
  }

  void TakePosition(const Plan& plan, const std::uint8_t* payload) {
    if (has_gps_ || !plan.Has(0, 2)) return;
    GnssSample sample;
    sample.t_s = plan.TimeS(payload);
    sample.position = {plan.Number(0, payload), plan.Number(1, payload)};
    sample.height_amsl_m = plan.Get(2, payload);
    builder_.Add(sample);
  }

  void TakeAttitude(const Plan& plan, const std::uint8_t* payload) {
    if (plan.meaning.rank != attitude_rank_ || !plan.Has(0, 2)) return;
    if (!attitude_instance_) attitude_instance_ = plan.Instance(payload);
    if (*attitude_instance_ != plan.Instance(payload)) return;
    builder_.Add(AttitudeSample{plan.TimeS(payload), NedFromYawPitchRoll(DegToRad(plan.Number(2, payload)),
                                                                         DegToRad(plan.Number(1, payload)),
                                                                         DegToRad(plan.Number(0, payload)))});
  }

  // Yaw from north; of two mounts the first.
  void TakeMount(const Plan& plan, const std::uint8_t* payload) {
    const auto roll_deg = plan.Get(0, payload), pitch_deg = plan.Get(1, payload),
               yaw_deg = plan.Get(2, payload);
    if (plan.Instance(payload) != mount_ || !roll_deg || !pitch_deg || !yaw_deg) return;
    has_mount_looked_down_ = has_mount_looked_down_ || *pitch_deg < -1.0;
    builder_.AddGimbal({plan.TimeS(payload),
                        NedFromYawPitchRoll(DegToRad(*yaw_deg), DegToRad(*pitch_deg), DegToRad(*roll_deg))});
  }

  void TakeCamera(const Plan& plan, const std::uint8_t* payload) {
    if (plan.meaning.rank != camera_rank_) return;
    CameraEvent event;
    // With a feedback pin CAM is the shutter and TRIG the command; alone, either is the command.
    event.is_feedback = has_trigger_;
    if (plan.Has(2, 3)) event.position = geo::LatLon{plan.Number(2, payload), plan.Number(3, payload)};
    event.height_amsl_m = plan.Get(4, payload);
    event.height_above_takeoff_m = plan.Get(5, payload);
    if (const auto sequence = plan.Get(10, payload)) event.sequence = std::llround(*sequence);
    if (plan.Has(7, 9)) {
      event.yaw_pitch_roll_rad =
          Eigen::Vector3d(DegToRad(plan.Number(9, payload)), DegToRad(plan.Number(8, payload)),
                          DegToRad(plan.Number(7, payload)));
    }
    if (plan.time != nullptr) {
      event.t_s = plan.TimeS(payload);
      builder_.Add(event);
      return;
    }
    const auto utc = UtcOf(plan.Get(0, payload), plan.Get(1, payload));
    if (utc && events_without_time_.size() < 100'000) events_without_time_.emplace_back(event, *utc);
  }

  LogBuilder& builder_;
  int imu_;
  bool uses_raw_imu_;
  RawImuPairing raw_imu_;
  int gps_;
  int baro_;
  int attitude_rank_;
  int mount_;
  bool has_mount_looked_down_ = false;
  int camera_rank_;
  bool has_gps_;
  bool has_trigger_;
  std::optional<int> attitude_instance_;
  std::optional<GnssSample> gnss_;  // waits for its GPA
  ClockPairs clock_;
  std::vector<std::pair<CameraEvent, UtcTime>> events_without_time_;
};

template <typename Walk>
Result<FlightLog> ParseBy(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  LogBuilder builder("dataflash", name);
  const auto give = [&](Walk& walk, auto& taker) {
    Plans plans;
    walk.Run(
        bytes, consumed, [&](std::uint8_t type) { plans[type] = MakeDataflashPlan(walk.layouts[type]); },
        [&](std::uint8_t type, const std::uint8_t* payload) {
          if (plans[type].meaning.kind != Kind::kOther) taker.Take(plans[type], payload);
        });
  };
  Census census;
  Walk walk;
  give(walk, census);
  std::uint64_t messages = 0;
  for (std::size_t type = 0; type < 256; ++type) {
    if (walk.counts[type] == 0) continue;
    const std::string& known = walk.layouts[type].name;
    builder.Count(type == kDataflashFmt ? "FMT" : known, walk.counts[type]);
    if (type != kDataflashFmt) messages += walk.counts[type];
  }
  if (messages == 0) {
    return Because(ErrorCode::kCorrupt, {RemarkCode::kDataflashEmpty, {{"file", name}}},
                   fmt::format("{} bytes, {} skipped", bytes.size(), walk.skipped_bytes));
  }
  if (walk.skipped_bytes > 0) builder.Warn({RemarkCode::kBytesDamaged, {{"bytes", walk.skipped_bytes}}});
  if (walk.ends_inside_message) builder.Warn(RemarkCode::kCutInMessage);

  DataflashReader reader(census, builder);
  Walk again;
  give(again, reader);
  reader.Finish();
  if (const std::size_t imus = census.Of(Kind::kImu).size(); imus > 1)
    builder.Warn({RemarkCode::kOneImuOf, {{"imus", imus}, {"used", reader.imu() + 1}}});
  return std::move(builder).Finish();
}

}  // namespace

bool LooksLikeDataflash(LogBytes head) {
  // A whole log starts with FMT; a cut one has message heads early on.
  if (head.size() >= 3 && head[0] == 0xA3 && head[1] == 0x95 && head[2] == kDataflashFmt) return true;
  const std::size_t most = std::min<std::size_t>(head.size(), 4096);
  for (std::size_t i = 0; i + kDataflashFmtLength + 3 <= most; ++i) {
    if (head[i] == 0xA3 && head[i + 1] == 0x95 && head[i + 2] == kDataflashFmt &&
        head[i + kDataflashFmtLength] == 0xA3 && head[i + kDataflashFmtLength + 1] == 0x95) {
      return true;
    }
  }
  return false;
}

Result<FlightLog> ParseDataflash(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  return ParseBy<DataflashWalk>(name, bytes, consumed);
}

Result<FlightLog> ParseDataflashText(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed) {
  return ParseBy<DataflashTextWalk>(name, bytes, consumed);
}

}  // namespace skyquilt::flight
