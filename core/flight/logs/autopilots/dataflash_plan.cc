#include "core/flight/logs/autopilots/dataflash_plan.h"

#include <algorithm>
#include <string_view>

namespace skyquilt::flight {
namespace {

using Kind = DataflashKind;

const std::map<std::string_view, DataflashMeaning>& Meanings() {
  static const std::map<std::string_view, DataflashMeaning> meanings = {
      {"IMU", {Kind::kImu, 0, 0}},       {"IMU2", {Kind::kImu, 1, 0}},      {"IMU3", {Kind::kImu, 2, 0}},
      {"GYR", {Kind::kRawGyro, 0, 0}},   {"GYR1", {Kind::kRawGyro, 0, 0}},  {"GYR2", {Kind::kRawGyro, 1, 0}},
      {"GYR3", {Kind::kRawGyro, 2, 0}},  {"ACC", {Kind::kRawAccel, 0, 0}},  {"ACC1", {Kind::kRawAccel, 0, 0}},
      {"ACC2", {Kind::kRawAccel, 1, 0}}, {"ACC3", {Kind::kRawAccel, 2, 0}}, {"VIBE", {Kind::kVibe, 0, 0}},
      {"GPS", {Kind::kGps, 0, 0}},       {"GPS2", {Kind::kGps, 1, 0}},      {"GPA", {Kind::kGpa, 0, 0}},
      {"GPA2", {Kind::kGpa, 1, 0}},      {"BARO", {Kind::kBaro, 0, 0}},     {"BAR2", {Kind::kBaro, 1, 0}},
      {"RFND", {Kind::kRange, 0, 0}},    {"POS", {Kind::kPosition, 0, 0}},  {"ATT", {Kind::kAttitude, 0, 0}},
      {"AHR2", {Kind::kAttitude, 0, 1}}, {"XKF1", {Kind::kAttitude, 0, 2}}, {"NKF1", {Kind::kAttitude, 0, 3}},
      {"EKF1", {Kind::kAttitude, 0, 4}}, {"CAM", {Kind::kCamera, 0, 0}},    {"TRIG", {Kind::kCamera, 0, 1}}};
  return meanings;
}

// Raw sensors note when they sampled, besides when the row was written.
void UseSampleTime(const DataflashLayout& layout, DataflashPlan& plan) {
  const DataflashField* sampled = layout.Find({"SampleUS"});
  if (sampled == nullptr) return;
  plan.time = sampled;
  plan.seconds_per_unit = 1e-6;
}

}  // namespace

DataflashPlan MakeDataflashPlan(const DataflashLayout& layout) {
  DataflashPlan plan;
  const auto known = Meanings().find(layout.name);
  if (known == Meanings().end() || layout.fields.empty()) return plan;
  plan.meaning = known->second;
  const auto otherwise = [&](std::size_t i, std::string_view name) {
    if (plan.f[i] == nullptr) plan.f[i] = layout.Find({name});
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
    case Kind::kRawGyro:
      set_all({"GyrX", "GyrY", "GyrZ"});
      UseSampleTime(layout, plan);
      break;
    case Kind::kRawAccel:
      set_all({"AccX", "AccY", "AccZ"});
      UseSampleTime(layout, plan);
      break;
    case Kind::kVibe:
      plan.instance = layout.Find({"IMU"});
      set_all({"Clip", "Clip0", "Clip1", "Clip2"});
      break;
    case Kind::kGps:
      set_all({"Status", "GMS", "GWk", "Lat", "Lng", "Alt", "Spd", "GCrs", "VZ"});
      otherwise(1, "TimeMS");
      otherwise(2, "Week");
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
        plan.f[0] = layout.Find({"Dist1"});
        plan.f[1] = layout.Find({"Orient1"});
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
      otherwise(7, "R");
      otherwise(8, "P");
      otherwise(9, "Y");
      break;
    case Kind::kOther:
      break;
  }
  if (plan.time == nullptr && plan.meaning.kind != Kind::kCamera) plan.meaning.kind = Kind::kOther;
  return plan;
}

void DataflashCensus::Take(const DataflashPlan& plan, const std::uint8_t* payload) {
  switch (plan.meaning.kind) {
    case Kind::kImu:
      ++imu_counts[plan.Instance(payload)];
      break;
    case Kind::kRawGyro:
      ++raw_gyro_counts[plan.Instance(payload)];
      break;
    case Kind::kRawAccel:
      ++raw_accel_counts[plan.Instance(payload)];
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

int DataflashCensus::BestImu() const {
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

int DataflashCensus::BestGps() const {
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

bool DataflashCensus::HasRawImu(int instance) const {
  const auto count = [&](const std::map<int, std::uint64_t>& counts) {
    const auto found = counts.find(instance);
    return found == counts.end() ? std::uint64_t{0} : found->second;
  };
  const std::uint64_t merged = count(imu_counts);
  return 2 * count(raw_gyro_counts) > 3 * merged && 2 * count(raw_accel_counts) > 3 * merged &&
         count(raw_gyro_counts) > 0 && count(raw_accel_counts) > 0;
}

}  // namespace skyquilt::flight
