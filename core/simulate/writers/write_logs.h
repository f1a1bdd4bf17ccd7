// A FlightLog as the files that recorders write, and what the three writers share: its samples in the order
// in which a recorder would have written them, and little-endian bytes. Pure; any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/flight/logs/flight_log.h"

namespace skyquilt::simulate {

// The documented flight.csv: one row per sample, cells of other sensors empty.
std::string FlightCsv(const flight::FlightLog& log);

// An ArduPilot DataFlash log (.BIN): self-describing messages IMU, ATT, GPS, GPA, BARO, RFND, TRIG, CAM.
// Loses what the format cannot hold: positions are rounded to 1e-7 degrees, angles to 0.01 degrees, heights
// to 1 cm over the sea. Source: the layout strings of ArduPilot's LogStructure.h, as documented at
// ardupilot.org (Logmessages).
std::vector<std::uint8_t> DataflashBytes(const flight::FlightLog& log);

// A PX4 ULog (.ulg) with the topics sensor_combined, vehicle_attitude, vehicle_gps_position,
// vehicle_air_data, distance_sensor, camera_capture and camera_trigger. Source: the ULog file format,
// docs.px4.io (version 1).
std::vector<std::uint8_t> UlogBytes(const flight::FlightLog& log);

using LogRecord =
    std::variant<const flight::ImuSample*, const flight::AttitudeSample*, const flight::GnssSample*,
                 const flight::BaroSample*, const flight::RangeSample*, const flight::CameraEvent*>;

inline double TimeOf(const LogRecord& record) {
  return std::visit([](const auto* sample) { return sample->t_s; }, record);
}

// By time; at one time in the order of the variant.
inline std::vector<LogRecord> RecordsInTime(const flight::FlightLog& log) {
  std::vector<LogRecord> records;
  records.reserve(log.imu.size() + log.attitude.size() + log.gnss.size() + log.baro.size() +
                  log.range.size() + log.events.size());
  const auto add = [&records](const auto& series) {
    for (const auto& sample : series) records.emplace_back(&sample);
  };
  add(log.imu);
  add(log.attitude);
  add(log.gnss);
  add(log.baro);
  add(log.range);
  add(log.events);
  std::stable_sort(records.begin(), records.end(),
                   [](const LogRecord& a, const LogRecord& b) { return TimeOf(a) < TimeOf(b); });
  return records;
}

// What the autopilot knew last: it is copied into a camera message.
struct AutopilotKnowledge {
  const flight::AttitudeSample* attitude = nullptr;
  const flight::GnssSample* gnss = nullptr;
  const flight::BaroSample* baro = nullptr;

  void Take(const LogRecord& record) {
    if (const auto* const* a = std::get_if<const flight::AttitudeSample*>(&record)) attitude = *a;
    if (const auto* const* g = std::get_if<const flight::GnssSample*>(&record)) gnss = *g;
    if (const auto* const* b = std::get_if<const flight::BaroSample*>(&record)) baro = *b;
  }
};

class ByteWriter {
 public:
  template <typename T>
  ByteWriter& Put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    std::uint8_t raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));  // both formats are little-endian, as every machine this runs on
    bytes_.insert(bytes_.end(), raw, raw + sizeof(T));
    return *this;
  }
  // Exactly `size` bytes: cut or filled with zeros.
  ByteWriter& PutText(std::string_view text, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      bytes_.push_back(i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0);
    return *this;
  }
  std::vector<std::uint8_t>& bytes() { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

}  // namespace skyquilt::simulate
