// FromBase64: bytes that cameras write as text into their tags (RFC 4648, with or without its padding).
// Pure; any thread.
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

}  // namespace skyquilt::flight
