#include "storage/tags/flight_tags.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/try.h"

namespace skyquilt::storage {
namespace {

// Bytes of UTF-8 that begin a character.
std::size_t CharactersOf(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

bool IsControl(char c) { return (c >= 0 && c < ' ') || c == 0x7F; }

Result<void> CheckTag(const std::string& tag) {
  if (tag.empty() || tag.size() > kMaxTagBytes || CharactersOf(tag) > kMaxTagCharacters) {
    return Error{
        ErrorCode::kUnprocessable,
        fmt::format("A tag has 1 to {} characters, and at most {} bytes.", kMaxTagCharacters, kMaxTagBytes),
        ""};
  }
  if (tag.front() == ' ' || tag.back() == ' ') {
    return Error{ErrorCode::kUnprocessable, fmt::format("The tag \"{}\" begins or ends with a space.", tag),
                 ""};
  }
  if (std::any_of(tag.begin(), tag.end(), [](char c) { return c == ',' || IsControl(c); })) {
    return Error{ErrorCode::kUnprocessable, "A tag has no commas, line breaks or other control characters.",
                 ""};
  }
  return {};
}

}  // namespace

Result<std::vector<std::string>> CheckedTags(std::vector<std::string> tags) {
  for (const std::string& tag : tags) SKYQUILT_TRY(CheckTag(tag));
  std::sort(tags.begin(), tags.end());
  tags.erase(std::unique(tags.begin(), tags.end()), tags.end());
  if (tags.size() > kMaxTags) {
    return Error{ErrorCode::kUnprocessable, fmt::format("A flight has at most {} tags.", kMaxTags), ""};
  }
  return tags;
}

std::string TagsText(const std::vector<std::string>& tags) {
  std::string text;
  for (const std::string& tag : tags) text += (text.empty() ? "\n" : "") + tag + "\n";
  return text;
}

std::vector<std::string> TagsFrom(std::string_view text) {
  std::vector<std::string> tags;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (end > 0) tags.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return tags;
}

}  // namespace skyquilt::storage
