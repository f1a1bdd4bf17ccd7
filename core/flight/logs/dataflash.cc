#include "core/flight/logs/dataflash.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/flight/logs/dataflash_walk.h"
#include "core/flight/logs/gps_time.h"
#include "core/flight/logs/log_builder.h"

namespace skyquilt::flight {
namespace {

using geo::DegToRad;

enum class Kind { kOther, kImu, kVibe, kGps, kGpa, kBaro, kRange, kPosition, kAttitude, kCamera };

// What a message is for us, from its name: "IMU2" is instance 1 of IMU where the layout has no instance
// field.
struct Meaning {
  Kind kind = Kind::kOther;
  int instance = 0;
  int rank = 0;  // among sources of the same thing the lowest wins
};

const std::map<std::string_view, Meaning>& Meanings() {
  static const std::map<std::string_view, Meaning> meanings = {
      {"IMU", {Kind::kImu, 0, 0}},       {"IMU2", {Kind::kImu, 1, 0}},      {"IMU3", {Kind::kImu, 2, 0}},
      {"VIBE", {Kind::kVibe, 0, 0}},     {"GPS", {Kind::kGps, 0, 0}},       {"GPS2", {Kind::kGps, 1, 0}},
      {"GPA", {Kind::kGpa, 0, 0}},       {"GPA2", {Kind::kGpa, 1, 0}},      {"BARO", {Kind::kBaro, 0, 0}},
      {"BAR2", {Kind::kBaro, 1, 0}},     {"RFND", {Kind::kRange, 0, 0}},    {"POS", {Kind::kPosition, 0, 0}},
      {"ATT", {Kind::kAttitude, 0, 0}},  {"AHR2", {Kind::kAttitude, 0, 1}}, {"XKF1", {Kind::kAttitude, 0, 2}},
      {"NKF1", {Kind::kAttitude, 0, 3}}, {"EKF1", {Kind::kAttitude, 0, 4}}, {"CAM", {Kind::kCamera, 0, 0}},
      {"TRIG", {Kind::kCamera, 0, 1}}};
  return meanings;
}

// A layout with the fields we read already looked up.
struct Plan {
  Meaning meaning;
  const DataflashField* time = nullptr;
  double seconds_per_unit = 1e-6;
  const DataflashField* instance = nullptr;
  std::array<const DataflashField*, 13> f{};

  // f[i] as a number; nothing where the layout lacks it.
  std::optional<double> Get(std::size_t i, const std::uint8_t* payload) const {
    if (f[i] == nullptr) return std::nullopt;
    const double value = DataflashNumber(*f[i], payload);
    if (!std::isfinite(value)) return std::nullopt;
    return value;
  }
  double Number(std::size_t i, const std::uint8_t* payload) const { return DataflashNumber(*f[i], payload); }
  bool Has(std::size_t first, std::size_t last) const {
    for (std::size_t i = first; i <= last; ++i) {
      if (f[i] == nullptr) return false;
    }
    return true;
  }
  double TimeS(const std::uint8_t* payload) const {
    return DataflashNumber(*time, payload) * seconds_per_unit;
  }
  int Instance(const std::uint8_t* payload) const {
    return instance == nullptr ? meaning.instance : static_cast<int>(DataflashNumber(*instance, payload));
  }
};

Plan MakePlan(const DataflashLayout& layout) {
  Plan plan;
  const auto known = Meanings().find(layout.name);
  if (known == Meanings().end() || layout.fields.empty()) return plan;
  plan.meaning = known->second;
  const auto set = [&](std::size_t i, std::initializer_list<std::string_view> names) {
    plan.f[i] = layout.Find(names);
  };
  const auto set_all = [&](std::initializer_list<std::string_view> names) {
    std::size_t i = 0;
    for (const std::string_view name : names) plan.f[i++] = layout.Find({name});
  };
  plan.instance = layout.Find({"I", "Instance"});
  plan.time = layout.Find({"TimeUS"});
  if (plan.time == nullptr) {
    plan.seconds_per_unit = 1e-3;
    // In old GPS messages TimeMS is the GPS time of week and T the time since boot.
    plan.time = plan.meaning.kind == Kind::kGps ? layout.Find({"T"}) : layout.Find({"TimeMS"});
  }
  switch (plan.meaning.kind) {
    case Kind::kImu:
      set_all({"GyrX", "GyrY", "GyrZ", "AccX", "AccY", "AccZ"});
      break;
    case Kind::kVibe:
      plan.instance = layout.Find({"IMU"});
      set_all({"Clip", "Clip0", "Clip1", "Clip2"});
      break;
    case Kind::kGps:
      set_all({"Status", "GMS", "GWk", "Lat", "Lng", "Alt", "Spd", "GCrs", "VZ"});
      if (plan.f[1] == nullptr) set(1, {"TimeMS"});
      if (plan.f[2] == nullptr) set(2, {"Week"});
      break;
    case Kind::kGpa:
      set_all({"HAcc", "VAcc"});
      break;
    case Kind::kBaro:
      set_all({"Alt"});
      break;
    case Kind::kRange:
      set_all({"Dist", "Orient", "Stat"});
      if (plan.f[0] == nullptr) {
        set(0, {"Dist1"});
        set(1, {"Orient1"});
      }
      plan.instance = nullptr;
      break;
    case Kind::kPosition:
      set_all({"Lat", "Lng", "Alt"});
      break;
    case Kind::kAttitude:
      set_all({"Roll", "Pitch", "Yaw"});
      plan.instance = layout.Find({"C"});
      break;
    case Kind::kCamera:
      set_all({"GPSTime", "GPSWeek", "Lat", "Lng", "Alt", "RelAlt", "GPSAlt", "Roll", "Pitch", "Yaw", "Img"});
      if (plan.f[7] == nullptr) set(7, {"R"});
      if (plan.f[8] == nullptr) set(8, {"P"});
      if (plan.f[9] == nullptr) set(9, {"Y"});
      if (plan.f[6] == nullptr) set(6, {"GPSAlt"});
      break;
    case Kind::kOther:
      break;
  }
  if (plan.time == nullptr && plan.meaning.kind != Kind::kCamera) plan.meaning.kind = Kind::kOther;
  return plan;
}

using Plans = std::array<Plan, 256>;

// First reading: which instance of each sensor is the best for the whole run.
struct Census {
  std::map<int, std::uint64_t> imu_counts;
  std::map<int, double> clips;
  std::map<int, double> gps_quality;
  std::map<int, std::uint64_t> baro_counts;
  std::map<int, std::uint64_t> attitude_counts;  // by rank
  std::map<int, std::uint64_t> camera_counts;

  void Take(const Plan& plan, const std::uint8_t* payload) {
    switch (plan.meaning.kind) {
      case Kind::kImu:
        ++imu_counts[plan.Instance(payload)];
        break;
      case Kind::kVibe:
        if (plan.f[0] != nullptr) {
          double& clip = clips[plan.Instance(payload)];
          clip = std::max(clip, plan.Get(0, payload).value_or(0.0));
        }
        for (int i = 0; i < 3; ++i) {
          if (const auto clip = plan.Get(static_cast<std::size_t>(i) + 1, payload))
            clips[i] = std::max(clips[i], *clip);
        }
        break;
      case Kind::kGps:
        gps_quality[plan.Instance(payload)] += std::max(0.0, plan.Get(0, payload).value_or(0.0) - 2.0);
        break;
      case Kind::kBaro:
        ++baro_counts[plan.Instance(payload)];
        break;
      case Kind::kAttitude:
        ++attitude_counts[plan.meaning.rank];
        break;
      case Kind::kCamera:
        ++camera_counts[plan.meaning.rank];
        break;
      default:
        break;
    }
  }

  int BestImu() const {
    int best = -1;
    double best_clips = 0.0;
    std::uint64_t most = 0;
    for (const auto& [instance, count] : imu_counts) most = std::max(most, count);
    for (const auto& [instance, count] : imu_counts) {
      if (count * 10 < most * 9) continue;  // it died on the way
      const auto found = clips.find(instance);
      const double instance_clips = found == clips.end() ? 0.0 : found->second;
      if (best < 0 || instance_clips < best_clips) {
        best = instance;
        best_clips = instance_clips;
      }
    }
    return best;
  }
  int BestGps() const {
    int best = 0;
    double quality = -1.0;
    for (const auto& [instance, sum] : gps_quality) {
      if (sum > quality) {
        best = instance;
        quality = sum;
      }
    }
    return best;
  }
};

class DataflashReader {
 public:
  DataflashReader(const Census& census, LogBuilder& builder)
      : builder_(builder),
        imu_(census.BestImu()),
        gps_(census.BestGps()),
        baro_(census.baro_counts.empty() ? 0 : census.baro_counts.begin()->first),
        attitude_rank_(census.attitude_counts.empty() ? 0 : census.attitude_counts.begin()->first),
        camera_rank_(census.camera_counts.empty() ? 0 : census.camera_counts.begin()->first),
        has_gps_(!census.gps_quality.empty() && census.gps_quality.at(gps_) > 0.0),
        has_trigger_(census.camera_counts.size() > 1) {}

  void Take(const Plan& plan, const std::uint8_t* payload) {
    switch (plan.meaning.kind) {
      case Kind::kImu:
        TakeImu(plan, payload);
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
      case Kind::kCamera:
        TakeCamera(plan, payload);
        break;
      default:
        break;
    }
  }

  void Finish() {
    FlushGnss();
    const auto fit = clock_.Solve();
    if (fit) {
      builder_.log().utc_at_zero = fit->utc_at_zero;
      // The receiver reports 0.05 to 0.25 s late, which the scatter does not show.
      builder_.log().utc_sigma_s = std::hypot(0.15, fit->scatter_s);
    }
    for (auto& [event, utc] : events_without_time_) {
      if (fit) {
        event.t_s = std::chrono::duration<double>(utc - fit->utc_at_zero).count();
        builder_.Add(event);
      }
    }
    if (!fit && !events_without_time_.empty())
      builder_.Warn("camera events without a time since boot were dropped");
    if (!has_gps_ && builder_.gnss_count() > 0) {
      builder_.Warn("no GPS fix in this log; positions are the autopilot's own estimate (POS)");
    }
  }

  int imu() const { return imu_; }

 private:
  void TakeImu(const Plan& plan, const std::uint8_t* payload) {
    if (!plan.Has(0, 5) || plan.Instance(payload) != imu_) return;
    ImuSample sample;
    sample.t_s = plan.TimeS(payload);
    for (std::size_t i = 0; i < 3; ++i) {
      sample.angular_rate_radps[static_cast<Eigen::Index>(i)] = plan.Number(i, payload);
      sample.specific_force_mps2[static_cast<Eigen::Index>(i)] = plan.Number(i + 3, payload);
    }
    builder_.Add(sample);
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
    const auto tow_ms = plan.Get(1, payload);
    const auto week = plan.Get(2, payload);
    if (tow_ms && week) {
      const auto utc = UtcFromGpsWeek(std::llround(*week), std::llround(*tow_ms * 1e3));
      if (utc) clock_.Add(t_s, *utc);
    }
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
    AttitudeSample sample;
    sample.t_s = plan.TimeS(payload);
    sample.ned_from_body =
        NedFromYawPitchRoll(DegToRad(plan.Number(2, payload)), DegToRad(plan.Number(1, payload)),
                            DegToRad(plan.Number(0, payload)));
    builder_.Add(sample);
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
    const auto tow_ms = plan.Get(0, payload);
    const auto week = plan.Get(1, payload);
    if (!tow_ms || !week || events_without_time_.size() >= 100'000) return;
    const auto utc = UtcFromGpsWeek(std::llround(*week), std::llround(*tow_ms * 1e3));
    if (utc) events_without_time_.emplace_back(event, *utc);
  }

  LogBuilder& builder_;
  int imu_;
  int gps_;
  int baro_;
  int attitude_rank_;
  int camera_rank_;
  bool has_gps_;
  bool has_trigger_;
  std::optional<int> attitude_instance_;
  std::optional<GnssSample> gnss_;  // waits for its GPA
  ClockPairs clock_;
  std::vector<std::pair<CameraEvent, UtcTime>> events_without_time_;
};

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
  LogBuilder builder("dataflash", name);
  Plans plans;
  Census census;
  DataflashWalk walk;
  walk.Run(
      bytes, consumed, [&](std::uint8_t type) { plans[type] = MakePlan(walk.layouts[type]); },
      [&](std::uint8_t type, const std::uint8_t* payload, std::size_t) {
        if (plans[type].meaning.kind != Kind::kOther) census.Take(plans[type], payload);
      });
  std::uint64_t messages = 0;
  for (std::size_t type = 0; type < 256; ++type) {
    if (walk.counts[type] == 0) continue;
    const std::string& known = walk.layouts[type].name;
    builder.Count(type == kDataflashFmt ? "FMT" : known, walk.counts[type]);
    if (type != kDataflashFmt) messages += walk.counts[type];
  }
  if (messages == 0) {
    return Error{ErrorCode::kCorrupt,
                 fmt::format("{} holds no readable DataFlash message; copy it from the aircraft again", name),
                 fmt::format("{} bytes, {} skipped", bytes.size(), walk.skipped_bytes)};
  }
  if (walk.skipped_bytes > 0) builder.Warn(fmt::format("{} damaged bytes were skipped", walk.skipped_bytes));
  if (walk.ends_inside_message) builder.Warn("the file ends inside a message: it was cut off");

  DataflashReader reader(census, builder);
  Plans plans_again;
  DataflashWalk second;
  second.Run(
      bytes, consumed, [&](std::uint8_t type) { plans_again[type] = MakePlan(second.layouts[type]); },
      [&](std::uint8_t type, const std::uint8_t* payload, std::size_t) {
        if (plans_again[type].meaning.kind != Kind::kOther) reader.Take(plans_again[type], payload);
      });
  reader.Finish();
  if (census.imu_counts.size() > 1) {
    builder.Warn(fmt::format("{} IMUs were recorded; number {} (fewest clips) is used",
                             census.imu_counts.size(), reader.imu() + 1));
  }
  return std::move(builder).Finish();
}

}  // namespace skyquilt::flight
