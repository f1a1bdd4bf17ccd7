// ExplainUnknownTable: why a table of numbers that no reader knows is not read, so that nobody looks for its
// effect in vain: what its columns were taken for and what is missing. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/flight/logs/log_bytes.h"

namespace skyquilt::flight {

// `head`: the first bytes of a text that RecogniseLog does not know. A sentence or two where it looks like a
// table of measurements: a header of words above rows with as many cells, most of them numbers. Nothing for
// other texts.
std::optional<std::string> ExplainUnknownTable(LogBytes head, std::string_view name);

}  // namespace skyquilt::flight
