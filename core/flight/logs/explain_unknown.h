// Why a file that RecogniseLog does not know is not read, though it looks like a table, a list or a track, so
// that nobody looks for its effect in vain. `head`: its first bytes; nothing for other files. Pure.
#pragma once

#include <optional>
#include <string_view>

#include "core/flight/bytes/log_bytes.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

// A table of measurements: rows with as many cells as the first line, most of them numbers, coordinates or
// times, with or without names of columns above. Says what its columns were taken for, what stands in those
// that were not, and what is missing.
std::optional<Remark> ExplainUnknownTable(LogBytes head, std::string_view name);

// A list of positions or of surveyed points: a row names a photo beside cells that should be numbers. Says in
// which line and column.
std::optional<Remark> ExplainUnknownList(LogBytes head, std::string_view name);

// A file that is named like a track or subtitles. Says what it lacks, with its first line.
std::optional<Remark> ExplainUnknownTrack(LogBytes head, std::string_view name);

}  // namespace skyquilt::flight
