// FromBase64: bytes that cameras write as text into their tags (RFC 4648, with or without its padding), and
// the little-endian numbers in them. Pure; any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace skyquilt::flight {

// Blanks and line ends may stand anywhere, '=' only at the end. Nothing for other characters or for more than
// `max_bytes`.
std::optional<std::vector<std::uint8_t>> FromBase64(std::string_view text, std::size_t max_bytes);

template <typename Number>
Number LittleEndian(const std::uint8_t* bytes) {
  Number number = 0;
  for (std::size_t i = 0; i < sizeof(Number); ++i) number |= static_cast<Number>(bytes[i]) << (8 * i);
  return number;
}

}  // namespace skyquilt::flight
