// ExplainUnknownTrack: why a file that is named like a track or subtitles is read as none, in the words of
// what it lacks and with its first line. Pure; any thread.
#pragma once

#include <optional>
#include <string_view>

#include "core/flight/bytes/log_bytes.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

// `head`: the first bytes of a file that RecogniseLog does not know. Nothing for other names.
std::optional<Remark> ExplainUnknownTrack(LogBytes head, std::string_view name);

}  // namespace skyquilt::flight
