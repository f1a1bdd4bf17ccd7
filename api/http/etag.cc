#include "api/http/etag.h"

#include <fmt/format.h>

namespace skyquilt::api {
namespace {

void SkipBlanks(std::string_view& text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
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

}  // namespace skyquilt::api
