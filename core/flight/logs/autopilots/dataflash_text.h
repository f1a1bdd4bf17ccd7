// Walking a DataFlash log that was converted to text (.log of Mission Planner and of ArduPilot's old
// terminal): a message a line, "GPS, 120200000, 3, ...", whose FMT lines name the fields of all others. The
// same as DataflashWalk to whoever is told of messages (dataflash.cc), but that every number is a double and
// already in the unit that its code stands for. Lines that fit no layout are skipped and counted, but for a
// heading before the first layout. One thread.
#pragma once

#include <map>
#include <string>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/logs/autopilots/dataflash_walk.h"

namespace skyquilt::flight {

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

// Whether one of the first lines is of that form.
bool LooksLikeDataflashText(LogBytes head);

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
      on_message(type->second, payload_.data(), payload_.size());
    } else if (lines.last_line_is_open()) {
      ends_inside_message = true;
    } else if (!types_.empty()) {
      skipped_bytes += line.size() + 1;
    }
  }
}

}  // namespace skyquilt::flight
