#include "api/http/range.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include "api/http/header_text.h"
#include "api/http/http_message.h"

namespace skyquilt::api {
namespace {

// Digits only. A number too large for 64 bits is as good as the largest one.
std::optional<std::uint64_t> ParseBytePosition(std::string_view text) {
  if (text.empty() || text.find_first_not_of("0123456789") != std::string_view::npos) return std::nullopt;
  std::uint64_t number = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  return parsed.ec == std::errc() ? number : UINT64_MAX;
}

}  // namespace

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
