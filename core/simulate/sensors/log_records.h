// The samples of a FlightLog in the order in which a recorder would have written them, and little-endian
// bytes: what the three log writers share. Any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <variant>
#include <vector>

#include "core/flight/logs/flight_log.h"

namespace skyquilt::simulate {

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
