#include "tests/core/flight/logs/log_writers.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>

namespace skyquilt::testing {
namespace {

// By AP_Logger's format characters; what is not named here has four bytes.
std::size_t SizeOf(char code) {
  const auto is_one_of = [code](std::string_view codes) {
    return codes.find(code) != std::string_view::npos;
  };
  if (is_one_of("bBM")) return 1;
  if (is_one_of("hHcC")) return 2;
  if (is_one_of("qQd")) return 8;
  if (is_one_of("N")) return 16;
  return is_one_of("Z") ? 64 : 4;
}

void AppendCode(Bytes& bytes, char code, double value) {
  switch (code) {
    case 'b':
    case 'B':
    case 'M':
      bytes.push_back(static_cast<std::uint8_t>(std::llround(value)));
      break;
    case 'h':
    case 'H':
      Append(bytes, static_cast<std::uint16_t>(std::llround(value)));
      break;
    case 'c':
    case 'C':
      Append(bytes, static_cast<std::uint16_t>(std::llround(value * 100.0)));
      break;
    case 'i':
    case 'I':
      Append(bytes, static_cast<std::uint32_t>(std::llround(value)));
      break;
    case 'e':
    case 'E':
      Append(bytes, static_cast<std::uint32_t>(std::llround(value * 100.0)));
      break;
    case 'L':
      Append(bytes, static_cast<std::int32_t>(std::llround(value * 1e7)));
      break;
    case 'f':
      Append(bytes, static_cast<float>(value));
      break;
    case 'd':
      Append(bytes, value);
      break;
    case 'q':
    case 'Q':
      Append(bytes, static_cast<std::uint64_t>(std::llround(value)));
      break;
    default:
      bytes.resize(bytes.size() + SizeOf(code));
  }
}

}  // namespace

DataflashWriter::DataflashWriter() { WriteFmt(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"); }

void DataflashWriter::Define(std::uint8_t type, std::string_view name, std::string_view format,
                             std::string_view labels) {
  std::size_t length = 3;
  for (const char code : format) length += SizeOf(code);
  formats_[type] = format;
  WriteFmt(type, length, name, format, labels);
}

void DataflashWriter::WriteFmt(std::uint8_t type, std::size_t length, std::string_view name,
                               std::string_view format, std::string_view labels) {
  bytes_.insert(bytes_.end(), {0xA3, 0x95, 128, type, static_cast<std::uint8_t>(length)});
  AppendText(bytes_, name, 4);
  AppendText(bytes_, format, 16);
  AppendText(bytes_, labels, 64);
}

void DataflashWriter::Write(std::uint8_t type, std::initializer_list<double> values) {
  bytes_.insert(bytes_.end(), {0xA3, 0x95, type});
  auto value = values.begin();
  for (const char code : formats_.at(type)) AppendCode(bytes_, code, value == values.end() ? 0.0 : *value++);
}

UlogWriter::UlogWriter(bool with_flags, std::uint64_t appended_at) {
  bytes_ = {0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35, 0x01};
  Append(bytes_, std::uint64_t{1'000'000});
  if (!with_flags) return;
  Bytes flags(40, 0);
  if (appended_at != 0) {
    flags[8] = 1;
    std::memcpy(flags.data() + 16, &appended_at, 8);
  }
  Message('B', flags);
}

void UlogWriter::Message(char type, const Bytes& payload) {
  Append(bytes_, static_cast<std::uint16_t>(payload.size()));
  bytes_.push_back(static_cast<std::uint8_t>(type));
  bytes_.insert(bytes_.end(), payload.begin(), payload.end());
}

void UlogWriter::Define(std::string_view definition) {
  Message('F', Bytes(definition.begin(), definition.end()));
}

void UlogWriter::Subscribe(std::uint16_t id, std::string_view topic, std::uint8_t instance) {
  Bytes payload{instance};
  Append(payload, id);
  payload.insert(payload.end(), topic.begin(), topic.end());
  Message('A', payload);
}

void UlogWriter::Data(std::uint16_t id, const Bytes& payload) {
  Bytes message;
  Append(message, id);
  message.insert(message.end(), payload.begin(), payload.end());
  Message('D', message);
}

void UlogWriter::Dropout(std::uint16_t milliseconds) {
  Bytes payload;
  Append(payload, milliseconds);
  Message('O', payload);
}

void TlogWriter::Packet(std::uint64_t ground_unix_us, std::uint32_t message_id, std::uint8_t crc_seed,
                        Bytes payload, bool second, std::uint8_t system_id) {
  for (int shift = 56; shift >= 0; shift -= 8)
    bytes_.push_back(static_cast<std::uint8_t>(ground_unix_us >> shift));
  if (second) {
    while (payload.size() > 1 && payload.back() == 0) payload.pop_back();
  }
  const std::size_t start = bytes_.size();
  const auto length = static_cast<std::uint8_t>(payload.size());
  if (second) {
    bytes_.insert(bytes_.end(),
                  {0xFD, length, 0, 0, sequence_++, system_id, 1, static_cast<std::uint8_t>(message_id),
                   static_cast<std::uint8_t>(message_id >> 8), static_cast<std::uint8_t>(message_id >> 16)});
  } else {
    bytes_.insert(bytes_.end(),
                  {0xFE, length, sequence_++, system_id, 1, static_cast<std::uint8_t>(message_id)});
  }
  bytes_.insert(bytes_.end(), payload.begin(), payload.end());
  // CRC-16/MCRF4XX bit by bit.
  std::uint16_t crc = 0xFFFF;
  const auto feed = [&](std::uint8_t byte) {
    crc = static_cast<std::uint16_t>(crc ^ byte);
    for (int i = 0; i < 8; ++i)
      crc = static_cast<std::uint16_t>((crc & 1) != 0 ? (crc >> 1) ^ 0x8408 : crc >> 1);
  };
  for (std::size_t i = start + 1; i < bytes_.size(); ++i) feed(bytes_[i]);
  feed(crc_seed);
  Append(bytes_, crc);
}

std::string SampleLogsFolder() {
  const char* given = std::getenv("SKYQUILT_DATA");
  const std::filesystem::path data = given != nullptr ? given : SKYQUILT_SOURCE_DIR "/../shared/data";
  const std::filesystem::path logs = data / "logs";
  return std::filesystem::is_directory(logs) ? logs.string() : "";
}

}  // namespace skyquilt::testing
