// Gzip: bytes to a gzip member that is always the same (no date, no name). Pure.
#pragma once

#include <string>
#include <string_view>

namespace skyquilt::storage {

std::string Gzip(std::string_view bytes);

}  // namespace skyquilt::storage
