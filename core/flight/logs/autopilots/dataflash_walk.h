// Walking a DataFlash log, binary or converted to text: finds the messages, learns their layouts, skips
// damage. The meaning of messages is dataflash_plan.h's. One thread.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/flight/bytes/log_bytes.h"
#include "core/flight/bytes/text_fields.h"

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
  const DataflashField* Find(const std::vector<std::string_view>& names) const;
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
  // Calls on_message(type, payload) for every whole message but FMT; on_layout(type) whenever a type's layout
  // becomes known or changes.
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
      on_message(type, payload);
    }
    at += length;
  }
}

// A log that was converted to text (.log of Mission Planner and of ArduPilot's old terminal): a message a
// line, "GPS, 120200000, 3, ...", whose FMT lines name the fields of all others. The same as DataflashWalk to
// whoever is told of messages, but that every number is a double and already in the unit that its code stands
// for. Lines that fit no layout are skipped and counted, but for a heading before the first layout.
struct DataflashTextWalk : DataflashFound {
  // As DataflashWalk::Run.
  template <typename OnLayout, typename OnMessage>
  void Run(LogBytes bytes, const ConsumedUpTo& consumed, const OnLayout& on_layout,
           const OnMessage& on_message);

 private:
  // Of fields_, an FMT line; nothing where it is none.
  std::optional<std::uint8_t> LearnLayout();
  // Of fields_, into payload_; false where they do not fit.
  bool FillPayload(const DataflashLayout& layout);

  std::map<std::string, std::uint8_t, std::less<>> types_;
  std::vector<std::string_view> fields_;
  std::vector<std::uint8_t> payload_;
};

template <typename OnLayout, typename OnMessage>
void DataflashTextWalk::Run(LogBytes bytes, const ConsumedUpTo& consumed, const OnLayout& on_layout,
                            const OnMessage& on_message) {
  LineReader lines(TextOf(bytes));
  ConsumedSteps steps(consumed);
  std::string_view line;
  while (NextFilledLine(lines, steps, line)) {
    SplitFields(line, ',', fields_);
    if (fields_.front() == "FMT") {
      if (const auto learnt = LearnLayout()) on_layout(*learnt);
      ++counts[kDataflashFmt];
      continue;
    }
    const auto type = types_.find(fields_.front());
    if (type != types_.end() && FillPayload(layouts[type->second])) {
      ++counts[type->second];
      on_message(type->second, payload_.data());
    } else if (lines.last_line_is_open()) {
      ends_inside_message = true;
    } else if (!types_.empty()) {
      skipped_bytes += line.size() + 1;
    }
  }
}

}  // namespace skyquilt::flight
