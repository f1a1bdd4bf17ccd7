// ReadLog: a file in, a FlightLog out, whatever its format. The format is recognised by the first bytes; the
// name's extension only decides between formats that both fit. Files are mapped and their pages given back
// while they are read, so that memory is bounded whatever the size. Errors: kUnsupportedFormat (no format we
// read, or encrypted), kCorrupt, kUnprocessable, kNoPosition, kIo. Any thread.
#pragma once

#include <optional>
#include <string_view>

#include "core/base/result.h"
#include "core/flight/bytes/input_file.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

enum class LogKind {
  kFlight,
  kGcpList,  // not a flight log: ReadGcpList (gcp_list.h) reads it
};

// How many first bytes RecogniseLog wants to see (a shorter file: all of it).
inline constexpr std::size_t kRecogniseBytes = std::size_t{64} << 10;

// Nothing for what is no log. Error: kUnsupportedFormat for a log that we know but cannot read, with advice.
Result<std::optional<LogKind>> RecogniseLog(LogBytes head, std::string_view name);

Result<FlightLog> ReadLog(const InputFile& file);

// The same from memory.
Result<FlightLog> ParseLog(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
