// What makes a request conditional or partial (RFC 9110, 8.8.3, 13 and 14): entity tags, If-None-Match,
// If-Range and Range. Pure.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace skyquilt::api {

// A strong tag: the number in hexadecimal, with `variant` (a format, say) behind a dash when not empty.
std::string StrongEtag(std::uint64_t content_id, std::string_view variant = {});
// If-None-Match: true when the list names the tag or is "*"; weak comparison, as GET has it. Nonsense matches
// nothing.
bool EtagListMatches(std::string_view if_none_match, std::string_view etag);
// If-Range: one strong tag, equal to ours. Dates and weak tags never match.
bool IfRangeMatches(std::string_view if_range, std::string_view etag);

enum class RangeKind { kWhole, kPart, kUnsatisfiable };

struct ByteRange {
  RangeKind kind = RangeKind::kWhole;
  std::uint64_t first = 0;   // of kPart
  std::uint64_t length = 0;  // of kPart; at least 1
};

// Over a body of known length. One range is honoured; several, or a header that does not parse, mean the
// whole body, as the RFC allows.
ByteRange ParseRange(std::string_view header, std::uint64_t body_length);

}  // namespace skyquilt::api
