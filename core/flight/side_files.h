// Which files of a flight's folder are no photos and nobody's fault: logs, side files, notes. Any thread.
#pragma once

#include <string_view>

namespace skyquilt::flight {

// By the ending of the name; case does not matter.
bool IsSideFileName(std::string_view name);

}  // namespace skyquilt::flight
