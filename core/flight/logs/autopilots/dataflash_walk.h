// Walking a DataFlash log: finds the messages, learns their layouts, skips damage. The meaning of messages is
// dataflash.cc's. One thread.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/flight/bytes/log_bytes.h"

namespace skyquilt::flight {

// How numbers and texts are coded, by AP_Logger's format characters.
struct DataflashCode {
  char letter = 0;
  std::size_t size = 0;
  double (*number)(const std::uint8_t* from) = nullptr;  // null: of texts
  double unit = 1.0;                                     // SI or degrees
};

// One field of a message: where it lies in the payload and how it is coded.
struct DataflashField {
  std::string name;
  const DataflashCode* code = nullptr;
  std::size_t offset = 0;
};

struct DataflashLayout {
  std::string name;
  std::size_t length = 0;              // of the whole message with its three head bytes; 0: unknown type
  std::vector<DataflashField> fields;  // empty where the layout contradicts its length

  // The first of these names that the layout has and that holds a number.
  const DataflashField* Find(std::initializer_list<std::string_view> names) const;
};

// Of a field that Find gave, in SI units or degrees.
inline double DataflashNumber(const DataflashField& field, const std::uint8_t* payload) {
  return field.code->number(payload + field.offset) * field.code->unit;
}

// What a walk has found so far, by type of message.
struct DataflashFound {
  std::array<DataflashLayout, 256> layouts;
  std::array<std::uint64_t, 256> counts{};
  std::uint64_t skipped_bytes = 0;
  bool ends_inside_message = false;
};

struct DataflashWalk : DataflashFound {
  // Calls on_message(type, payload, payload_size) for every whole message but FMT; on_layout(type) whenever a
  // type's layout becomes known or changes.
  template <typename OnLayout, typename OnMessage>
  void Run(LogBytes bytes, const ConsumedUpTo& consumed, const OnLayout& on_layout,
           const OnMessage& on_message);

 private:
  bool LearnLayout(const std::uint8_t* payload, int& type);
  std::size_t FindNext(LogBytes bytes, std::size_t from) const;
  bool IsHead(LogBytes bytes, std::size_t at) const;
};

inline constexpr std::uint8_t kDataflashFmt = 128;
inline constexpr std::size_t kDataflashFmtLength = 89;

template <typename OnLayout, typename OnMessage>
void DataflashWalk::Run(LogBytes bytes, const ConsumedUpTo& consumed, const OnLayout& on_layout,
                        const OnMessage& on_message) {
  std::size_t at = 0;
  ConsumedSteps steps(consumed);
  while (at < bytes.size()) {
    steps.At(at);
    if (!IsHead(bytes, at)) {
      const std::size_t next = FindNext(bytes, at + 1);
      skipped_bytes += next - at;
      at = next;
      continue;
    }
    const std::uint8_t type = bytes[at + 2];
    const std::size_t length = type == kDataflashFmt ? kDataflashFmtLength : layouts[type].length;
    if (bytes.size() - at < length) {
      ends_inside_message = true;
      return;
    }
    const std::uint8_t* payload = bytes.data() + at + 3;
    ++counts[type];
    if (type == kDataflashFmt) {
      int learnt = 0;
      if (LearnLayout(payload, learnt)) on_layout(static_cast<std::uint8_t>(learnt));
    } else {
      on_message(type, payload, length - 3);
    }
    at += length;
  }
}

}  // namespace skyquilt::flight
