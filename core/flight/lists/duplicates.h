// Finding photos whose files hold the same bytes. Any thread.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/flight/bytes/input_file.h"

namespace skyquilt::flight {

// For each file the index of the first one with the same bytes, nothing where there is none. Files of one
// size are compared by a hash of their start, then byte for byte; unreadable files equal nothing.
std::vector<std::optional<std::size_t>> FindDuplicates(const std::vector<InputFile>& files);

}  // namespace skyquilt::flight
