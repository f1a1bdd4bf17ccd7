#include "api/http/conditional.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "api/http/http_message.h"
#include "core/base/text/plain_text.h"

namespace skyquilt::api {
namespace {

void SkipBlanks(std::string_view& text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
}

// Digits only. A number too large for 64 bits is as good as the largest one.
std::optional<std::uint64_t> ParseBytePosition(std::string_view text) {
  if (text.empty() || text.find_first_not_of("0123456789") != std::string_view::npos) return std::nullopt;
  std::uint64_t number = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  return parsed.ec == std::errc() ? number : UINT64_MAX;
}

}  // namespace

std::string StrongEtag(std::uint64_t content_id, std::string_view variant) {
  return variant.empty() ? fmt::format("\"{:016x}\"", content_id)
                         : fmt::format("\"{:016x}-{}\"", content_id, variant);
}

bool EtagListMatches(std::string_view list, std::string_view etag) {
  SkipBlanks(list);
  if (list == "*") return true;
  while (!list.empty()) {
    if (list.starts_with("W/")) list.remove_prefix(2);
    if (!list.starts_with('"')) return false;
    const std::size_t end = list.find('"', 1);
    if (end == std::string_view::npos) return false;
    if (list.substr(0, end + 1) == etag) return true;
    list.remove_prefix(end + 1);
    SkipBlanks(list);
    if (!list.empty() && list.front() != ',') return false;
    while (!list.empty() && (list.front() == ',' || list.front() == ' ')) list.remove_prefix(1);
  }
  return false;
}

bool IfRangeMatches(std::string_view if_range, std::string_view etag) { return if_range == etag; }

ByteRange ParseRange(std::string_view header, std::uint64_t body_length) {
  const std::size_t equals = header.find('=');
  if (equals == std::string_view::npos || !EqualsIgnoringCase(header.substr(0, equals), "bytes")) return {};
  const std::string_view spec = Trim(header.substr(equals + 1));
  const std::size_t dash = spec.find('-');
  if (dash == std::string_view::npos || spec.find(',') != std::string_view::npos) return {};
  const std::string_view first_text = spec.substr(0, dash);
  const std::string_view last_text = spec.substr(dash + 1);
  if (first_text.empty()) {
    const std::optional<std::uint64_t> suffix = ParseBytePosition(last_text);
    if (!suffix) return {};
    if (*suffix == 0 || body_length == 0) return {RangeKind::kUnsatisfiable, 0, 0};
    const std::uint64_t length = std::min(*suffix, body_length);
    return {RangeKind::kPart, body_length - length, length};
  }
  const std::optional<std::uint64_t> first = ParseBytePosition(first_text);
  if (!first) return {};
  std::uint64_t last = UINT64_MAX;
  if (!last_text.empty()) {
    const std::optional<std::uint64_t> given = ParseBytePosition(last_text);
    if (!given || *given < *first) return {};
    last = *given;
  }
  if (*first >= body_length) return {RangeKind::kUnsatisfiable, 0, 0};
  last = std::min(last, body_length - 1);
  return {RangeKind::kPart, *first, last - *first + 1};
}

}  // namespace skyquilt::api
