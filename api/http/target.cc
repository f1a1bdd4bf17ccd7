#include "api/http/target.h"

#include <fmt/format.h>

#include "core/base/text/percent.h"
#include "core/base/try.h"
#include "storage/uploads/photo_store.h"

namespace skyquilt::api {
namespace {

constexpr std::size_t kMaxSegments = 32;
constexpr std::size_t kMaxQueryItems = 64;

Error Refuse(const char* why) {
  return {ErrorCode::kInvalidArgument, fmt::format("Bad request target: {}.", why)};
}

bool IsUnreservedOrSub(char c) {
  return IsLetterOrDigit(c) || std::string_view("-._~!$&'()*+,;=:@").find(c) != std::string_view::npos;
}

Result<std::string> Decode(std::string_view text, std::string_view also_allowed, bool plus_is_space) {
  std::string decoded;
  decoded.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '%') {
      const int byte = PercentByte(text.substr(i));
      if (byte < 0) return Refuse("% must be followed by two hexadecimal digits");
      decoded.push_back(static_cast<char>(byte));
      i += 2;
    } else if (c == '+' && plus_is_space) {
      decoded.push_back(' ');
    } else if (IsUnreservedOrSub(c) || also_allowed.find(c) != std::string_view::npos) {
      decoded.push_back(c);
    } else {
      return Refuse("it has a character that must be percent-encoded");
    }
  }
  for (const char c : decoded) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) return Refuse("it has a control character");
  }
  if (!storage::IsValidUtf8(decoded)) return Refuse("it is not UTF-8");
  return decoded;
}

Result<std::vector<std::string>> ParsePath(std::string_view path) {
  std::vector<std::string> segments;
  segments.reserve(8);  // more than tiles have
  while (path.size() > 1) {
    path.remove_prefix(1);
    const std::size_t end = std::min(path.find('/'), path.size());
    SKYQUILT_TRY_ASSIGN(std::string segment, Decode(path.substr(0, end), "", false));
    if (segment.empty()) return Refuse("a path segment is empty");
    if (segment == "." || segment == "..") return Refuse("a path segment means a folder");
    if (segment.find_first_of("/\\") != std::string::npos) return Refuse("a path segment has a slash in it");
    if (segments.size() == kMaxSegments) return Refuse("the path has too many segments");
    segments.push_back(std::move(segment));
    path.remove_prefix(end);
  }
  if (path == "/" && !segments.empty()) return Refuse("a path segment is empty");
  return segments;
}

}  // namespace

Result<Target> ParseTarget(std::string_view target) {
  if (target.empty() || target.front() != '/') return Refuse("it must begin with a slash");
  if (target.size() > kMaxTargetBytes) return Refuse("it is too long");
  const std::size_t question = target.find('?');
  SKYQUILT_TRY_ASSIGN(std::vector<std::string> segments, ParsePath(target.substr(0, question)));
  Target parsed;
  parsed.segments = std::move(segments);
  if (question == std::string_view::npos) return parsed;
  SKYQUILT_TRY_ASSIGN(auto query, ParseQuery(target.substr(question + 1)));
  parsed.query = std::move(query);
  return parsed;
}

Result<std::vector<std::pair<std::string, std::string>>> ParseQuery(std::string_view rest) {
  std::vector<std::pair<std::string, std::string>> query;
  while (!rest.empty()) {
    const std::string_view item = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(item.size() + 1, rest.size()));
    if (item.empty()) continue;
    if (query.size() == kMaxQueryItems) return Refuse("the query has too many items");
    const std::size_t equals = item.find('=');
    SKYQUILT_TRY_ASSIGN(std::string name, Decode(item.substr(0, equals), "/?", true));
    // Brackets, which stand around the names of coordinate systems, browsers leave as they are.
    SKYQUILT_TRY_ASSIGN(std::string value, Decode(equals == std::string_view::npos ? std::string_view()
                                                                                   : item.substr(equals + 1),
                                                  "/?[]", true));
    query.emplace_back(std::move(name), std::move(value));
  }
  return query;
}

}  // namespace skyquilt::api
