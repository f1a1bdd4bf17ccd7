#include "api/http/digest.h"

#include <algorithm>

namespace skyquilt::api {

std::optional<std::string> Sha256OfContentDigest(std::string_view header) {
  while (!header.empty()) {
    const std::string_view item = header.substr(0, header.find(','));
    header.remove_prefix(std::min(item.size() + 1, header.size()));
    const std::size_t first = item.find_first_not_of(" \t");
    if (first == std::string_view::npos) continue;
    std::string_view member = item.substr(first, item.find_last_not_of(" \t") - first + 1);
    constexpr std::string_view kName = "sha-256=:";
    if (!member.starts_with(kName) || !member.ends_with(':') || member.size() == kName.size()) continue;
    member.remove_prefix(kName.size());
    member.remove_suffix(1);
    return DecodeBase64(member);
  }
  return std::nullopt;
}

}  // namespace skyquilt::api
