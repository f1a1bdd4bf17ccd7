// Writers of binary flight logs for tests and benchmarks: just enough of each format, written from its
// description and apart from the parsers. Bytes go to memory. One thread.
#pragma once

#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skyquilt::testing {

using Bytes = std::vector<std::uint8_t>;

template <typename T>
void Append(Bytes& bytes, T value) {
  const auto* from = reinterpret_cast<const std::uint8_t*>(&value);
  bytes.insert(bytes.end(), from, from + sizeof(T));
}

inline void AppendText(Bytes& bytes, std::string_view text, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i)
    bytes.push_back(i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0);
}

// ArduPilot: Define, then Write with values in the scale of a person (degrees, metres, seconds as
// microseconds).
class DataflashWriter {
 public:
  DataflashWriter();
  void Define(std::uint8_t type, std::string_view name, std::string_view format, std::string_view labels);
  void Write(std::uint8_t type, std::initializer_list<double> values);
  Bytes& bytes() { return bytes_; }

 private:
  void WriteFmt(std::uint8_t type, std::size_t length, std::string_view name, std::string_view format,
                std::string_view labels);
  std::map<std::uint8_t, std::string> formats_;
  Bytes bytes_;
};

// PX4: Define and Subscribe, then Data with a payload packed by the caller (timestamp first).
class UlogWriter {
 public:
  explicit UlogWriter(bool with_flags = true, std::uint64_t appended_at = 0);
  void Define(std::string_view definition);
  void Subscribe(std::uint16_t id, std::string_view topic, std::uint8_t instance = 0);
  void Data(std::uint16_t id, const Bytes& payload);
  void Dropout(std::uint16_t milliseconds);
  void Message(char type, const Bytes& payload);
  Bytes& bytes() { return bytes_; }

 private:
  Bytes bytes_;
};

// MAVLink telemetry log; payloads packed by the caller in the order of the wire.
class TlogWriter {
 public:
  void Packet(std::uint64_t ground_unix_us, std::uint32_t message_id, std::uint8_t crc_seed, Bytes payload,
              bool second, std::uint8_t system_id = 1);
  Bytes& bytes() { return bytes_; }

 private:
  Bytes bytes_;
  std::uint8_t sequence_ = 0;
};

// Where the real samples lie (SKYQUILT_DATA, else beside the source tree); empty where they are absent.
std::string SampleLogsFolder();

}  // namespace skyquilt::testing
