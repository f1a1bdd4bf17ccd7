// What the messages of a DataFlash log mean, the fields that are read of them, and which instance of each
// sensor serves the whole run. One thread.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "core/flight/logs/autopilots/dataflash_walk.h"

namespace skyquilt::flight {

enum class DataflashKind {
  kOther,
  kImu,
  kRawGyro,
  kRawAccel,
  kVibe,
  kGps,
  kGpa,
  kBaro,
  kRange,
  kPosition,
  kAttitude,
  kMount,
  kCamera
};
inline constexpr std::size_t kDataflashKinds = static_cast<std::size_t>(DataflashKind::kCamera) + 1;

// What a message is for us, from its name: "IMU2" is instance 1 of IMU where no field says it.
struct DataflashMeaning {
  DataflashKind kind = DataflashKind::kOther;
  int instance = 0;
  int rank = 0;  // among sources of the same thing the lowest wins
};

// A layout with the fields we read already looked up.
struct DataflashPlan {
  DataflashMeaning meaning;
  const DataflashField* time = nullptr;
  double seconds_per_unit = 1e-6;
  const DataflashField* instance = nullptr;
  std::array<const DataflashField*, 13> f{};  // as kFields (dataflash_plan.cc) orders them

  // f[i] as a number; nothing where the layout lacks it.
  std::optional<double> Get(std::size_t i, const std::uint8_t* payload) const {
    if (f[i] == nullptr) return std::nullopt;
    const double value = DataflashNumber(*f[i], payload);
    if (!std::isfinite(value)) return std::nullopt;
    return value;
  }
  double Number(std::size_t i, const std::uint8_t* payload) const { return DataflashNumber(*f[i], payload); }
  Eigen::Vector3d Vector(std::size_t first, const std::uint8_t* payload) const {
    return {Number(first, payload), Number(first + 1, payload), Number(first + 2, payload)};
  }
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
    if (instance == nullptr) return meaning.instance;
    const double number = DataflashNumber(*instance, payload);
    return number >= 0.0 && number < 16.0 ? static_cast<int>(number) : 16;
  }
};

DataflashPlan MakeDataflashPlan(const DataflashLayout& layout);

// First reading: which instance of each sensor is the best for the whole run.
struct DataflashCensus {
  // How many messages of each kind each instance has; of attitudes and cameras each rank.
  std::array<std::map<int, std::uint64_t>, kDataflashKinds> counts;
  std::map<int, double> clips;
  std::map<int, double> gps_quality;

  void Take(const DataflashPlan& plan, const std::uint8_t* payload);
  const std::map<int, std::uint64_t>& Of(DataflashKind kind) const {
    return counts[static_cast<std::size_t>(kind)];
  }
  // The lowest instance or rank; 0 where there is none.
  int First(DataflashKind kind) const { return Of(kind).empty() ? 0 : Of(kind).begin()->first; }
  int BestImu() const;
  // The gyroscope and accelerometer of this instance were also logged apart and much faster.
  bool HasRawImu(int instance) const;
  int BestGps() const;
};

}  // namespace skyquilt::flight
