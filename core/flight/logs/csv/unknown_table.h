// ExplainUnknownTable: why a table of numbers that no reader knows is not read, so that nobody looks for its
// effect in vain: what its columns were taken for, what stands in those that were not, and what is missing.
// Pure; any thread.
#pragma once

#include <optional>
#include <string_view>

#include "core/flight/bytes/log_bytes.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

// `head`: the first bytes of a text that RecogniseLog does not know. A sentence or two where it looks like a
// table of measurements: rows with as many cells as the first line, most of them numbers, coordinates or
// times, with or without names of columns above. Nothing for other texts.
std::optional<Remark> ExplainUnknownTable(LogBytes head, std::string_view name);

}  // namespace skyquilt::flight
