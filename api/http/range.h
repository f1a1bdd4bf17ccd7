// The Range header (RFC 9110 14) over a body of known length. One range is honoured; several, or a header
// that does not parse, mean the whole body, as the RFC allows. Pure.
#pragma once

#include <cstdint>
#include <string_view>

namespace skyquilt::api {

enum class RangeKind { kWhole, kPart, kUnsatisfiable };

struct ByteRange {
  RangeKind kind = RangeKind::kWhole;
  std::uint64_t first = 0;   // of kPart
  std::uint64_t length = 0;  // of kPart; at least 1
};

ByteRange ParseRange(std::string_view header, std::uint64_t body_length);

}  // namespace skyquilt::api
