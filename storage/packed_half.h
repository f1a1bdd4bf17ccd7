// The small picture of a block (RGBA, a square of a power of two) as a map's state keeps it: zlib, fastest.
// Pure; any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::storage {

std::vector<std::uint8_t> PackHalf(const std::vector<std::uint8_t>& rgba);
// Empty for nothing. Error: kCorrupt.
Result<std::vector<std::uint8_t>> UnpackHalf(std::span<const std::uint8_t> packed);

}  // namespace skyquilt::storage
