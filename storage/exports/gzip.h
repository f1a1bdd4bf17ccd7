// Gzip: bytes to a gzip member that is the same at any time (no date, no name). Pure; any thread.
#pragma once

#include <string>
#include <string_view>

namespace skyquilt::storage {

std::string Gzip(std::string_view bytes);

}  // namespace skyquilt::storage
