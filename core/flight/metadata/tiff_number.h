// The numbers of TIFF, which come in either byte order. Pure; any thread.
#pragma once

#include <cstddef>
#include <cstdint>

namespace skyquilt::flight {

// Of `size` bytes from `p`: 8 at most.
inline std::uint64_t UnsignedAt(const std::uint8_t* p, std::size_t size, bool is_big_endian) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = (value << 8) | p[is_big_endian ? i : size - 1 - i];
  return value;
}

inline std::uint32_t BigEndian32(const std::uint8_t* p) {
  return static_cast<std::uint32_t>(UnsignedAt(p, 4, true));
}

}  // namespace skyquilt::flight
