// ExplainUnknownList: why a text that looks like a list of positions or of surveyed points is read as none,
// by its line, column and cell, so that nobody looks for its effect in vain. Pure; any thread.
#pragma once

#include <optional>
#include <string_view>

#include "core/flight/bytes/log_bytes.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

// `head`: the first bytes of a text that RecogniseLog does not know. A sentence or two where a row names a
// photo beside cells that should be numbers; nothing for other texts.
std::optional<Remark> ExplainUnknownList(LogBytes head, std::string_view name);

}  // namespace skyquilt::flight
