// Entity tags (RFC 9110 8.8.3) and If-None-Match. Pure.
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

}  // namespace skyquilt::api
