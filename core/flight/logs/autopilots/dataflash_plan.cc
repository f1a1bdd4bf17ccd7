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
      {"EKF1", {Kind::kAttitude, 0, 4}}, {"CAM", {Kind::kCamera, 0, 0}},    {"TRIG", {Kind::kCamera, 0, 1}},
      {"MNT", {Kind::kMount, 0, 0}}};
  return meanings;
}

// The fields that are read of each kind, apart by blanks; | before another name of one.
struct FieldsOfKind {
  Kind kind;
  std::string_view names;
};
constexpr FieldsOfKind kFields[] = {
    {Kind::kImu, "GyrX GyrY GyrZ AccX AccY AccZ"},
    {Kind::kRawGyro, "GyrX GyrY GyrZ"},
    {Kind::kRawAccel, "AccX AccY AccZ"},
    {Kind::kVibe, "Clip Clip0 Clip1 Clip2"},
    {Kind::kGps, "Status GMS|TimeMS GWk|Week Lat Lng Alt Spd GCrs VZ"},
    {Kind::kGpa, "HAcc VAcc"},
    {Kind::kBaro, "Alt"},
    {Kind::kRange, "Dist Orient Stat"},
    {Kind::kPosition, "Lat Lng Alt"},
    {Kind::kAttitude, "Roll Pitch Yaw"},
    {Kind::kMount, "Roll Pitch YawE"},
    {Kind::kCamera, "GPSTime GPSWeek Lat Lng Alt RelAlt GPSAlt Roll|R Pitch|P Yaw|Y Img"},
};

void LookUpFields(const DataflashLayout& layout, DataflashPlan& plan) {
  std::vector<std::string_view> fields, names;
  for (const FieldsOfKind& each : kFields) {
    if (each.kind != plan.meaning.kind) continue;
    SplitBlanks(each.names, fields);
    for (std::size_t i = 0; i < fields.size(); ++i) {
      SplitFields(fields[i], '|', names);
      plan.f[i] = layout.Find(names);
    }
  }
}

}  // namespace

DataflashPlan MakeDataflashPlan(const DataflashLayout& layout) {
  DataflashPlan plan;
  const auto known = Meanings().find(layout.name);
  if (known == Meanings().end() || layout.fields.empty()) return plan;
  plan.meaning = known->second;
  plan.instance = layout.Find({"I", "Instance"});
  plan.time = layout.Find({"TimeUS"});
  if (plan.time == nullptr) {
    plan.seconds_per_unit = 1e-3;
    // In old GPS messages TimeMS is the GPS time of week and T the time since boot.
    plan.time = plan.meaning.kind == Kind::kGps ? layout.Find({"T"}) : layout.Find({"TimeMS"});
  }
  LookUpFields(layout, plan);
  switch (plan.meaning.kind) {
    case Kind::kRawGyro:
    case Kind::kRawAccel:  // they note when they sampled, besides when the row was written
      if (const DataflashField* sampled = layout.Find({"SampleUS"})) {
        plan.time = sampled;
        plan.seconds_per_unit = 1e-6;
      }
      break;
    case Kind::kVibe:
      plan.instance = layout.Find({"IMU"});
      break;
    case Kind::kRange:
      if (plan.f[0] == nullptr) {
        plan.f[0] = layout.Find({"Dist1"});
        plan.f[1] = layout.Find({"Orient1"});
      }
      plan.instance = nullptr;
      break;
    case Kind::kAttitude:
      plan.instance = layout.Find({"C"});
      break;
    default:
      break;
  }
  if (plan.time == nullptr && plan.meaning.kind != Kind::kCamera) plan.meaning.kind = Kind::kOther;
  return plan;
}

void DataflashCensus::Take(const DataflashPlan& plan, const std::uint8_t* payload) {
  const Kind kind = plan.meaning.kind;
  const int instance = plan.Instance(payload);
  const bool is_ranked = kind == Kind::kAttitude || kind == Kind::kCamera;
  ++counts[static_cast<std::size_t>(kind)][is_ranked ? plan.meaning.rank : instance];
  if (kind == Kind::kGps) {
    gps_quality[instance] += std::max(0.0, plan.Get(0, payload).value_or(0.0) - 2.0);
  } else if (kind == Kind::kVibe) {
    if (plan.f[0] != nullptr) {
      double& clip = clips[instance];
      clip = std::max(clip, plan.Get(0, payload).value_or(0.0));
    }
    for (int i = 0; i < 3; ++i) {
      if (const auto clip = plan.Get(static_cast<std::size_t>(i) + 1, payload))
        clips[i] = std::max(clips[i], *clip);
    }
  }
}

int DataflashCensus::BestImu() const {
  int best = -1;
  double best_clips = 0.0;
  std::uint64_t most = 0;
  const std::map<int, std::uint64_t>& imu_counts = Of(Kind::kImu);
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
  const auto best = std::ranges::max_element(gps_quality, {}, [](const auto& one) { return one.second; });
  return best == gps_quality.end() ? 0 : best->first;
}

bool DataflashCensus::HasRawImu(int instance) const {
  const auto count = [&](Kind kind) {
    const auto found = Of(kind).find(instance);
    return found == Of(kind).end() ? std::uint64_t{0} : found->second;
  };
  const std::uint64_t merged = count(Kind::kImu), gyro = count(Kind::kRawGyro),
                      accel = count(Kind::kRawAccel);
  return 2 * gyro > 3 * merged && 2 * accel > 3 * merged;
}

}  // namespace skyquilt::flight
