#include "api/uploads/tus_headers.h"

#include "core/base/text/plain_text.h"

namespace skyquilt::api {
namespace {

constexpr std::size_t kMaxMetadataBytes = 8192;

bool IsKeyCharacter(char c) { return c > ' ' && c < 0x7f && c != ','; }

}  // namespace

std::optional<std::int64_t> ParseTusNumber(std::string_view text) {
  constexpr std::size_t kMaxDigits = 16;
  constexpr std::int64_t kLargest = std::int64_t{1} << 53;
  if (text.size() > kMaxDigits || text.starts_with('-')) return std::nullopt;
  const auto number = ParseNumber<std::int64_t>(text);
  return number && *number <= kLargest ? number : std::nullopt;
}

std::optional<std::map<std::string, std::string>> ParseTusMetadata(std::string_view text) {
  std::map<std::string, std::string> metadata;
  if (text.size() > kMaxMetadataBytes) return std::nullopt;
  while (!text.empty()) {
    std::string_view item = text.substr(0, text.find(','));
    const bool has_more = item.size() < text.size();
    text.remove_prefix(std::min(item.size() + 1, text.size()));
    if (has_more && text.empty()) return std::nullopt;
    while (item.starts_with(' ')) item.remove_prefix(1);
    while (item.ends_with(' ')) item.remove_suffix(1);
    const std::string_view key = item.substr(0, item.find(' '));
    if (key.empty()) return std::nullopt;
    for (const char c : key) {
      if (!IsKeyCharacter(c)) return std::nullopt;
    }
    std::string value;
    if (key.size() < item.size()) {
      std::optional<std::string> decoded = DecodeBase64(item.substr(key.size() + 1));
      if (!decoded) return std::nullopt;
      value = *std::move(decoded);
    }
    if (!metadata.emplace(key, std::move(value)).second) return std::nullopt;
  }
  return metadata;
}

std::optional<TusChecksum> ParseTusChecksum(std::string_view text) {
  const std::size_t space = text.find(' ');
  if (space == std::string_view::npos) return std::nullopt;
  const std::string_view name = text.substr(0, space);
  TusChecksum checksum;
  std::size_t size = 20;
  if (name == "sha256") {
    checksum.algorithm = DigestAlgorithm::kSha256;
    size = 32;
  } else if (name != "sha1") {
    return std::nullopt;
  }
  std::optional<std::string> digest = DecodeBase64(text.substr(space + 1));
  if (!digest || digest->size() != size) return std::nullopt;
  checksum.digest = *std::move(digest);
  return checksum;
}

std::optional<TusConcat> ParseTusConcat(std::string_view text) {
  TusConcat concat;
  if (text == "partial") return concat;
  constexpr std::string_view kFinal = "final;";
  if (!text.starts_with(kFinal)) return std::nullopt;
  concat.is_final = true;
  text.remove_prefix(kFinal.size());
  while (!text.empty()) {
    std::string_view address = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(address.size() + 1, text.size()));
    if (address.empty()) continue;
    address = address.substr(0, address.find_first_of("?#"));
    address.remove_prefix(address.rfind('/') + 1);  // from the start where there is none
    if (address.empty()) return std::nullopt;
    concat.parts.emplace_back(address);
  }
  if (concat.parts.empty()) return std::nullopt;
  return concat;
}

}  // namespace skyquilt::api
