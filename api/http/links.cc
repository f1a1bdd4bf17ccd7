#include "api/http/links.h"

#include <fmt/format.h>

#include <algorithm>

namespace skyquilt::api {

std::string TokenInQuery(const Request& request) {
  const std::string_view token = request.Query("token").value_or("");
  const bool is_plain = std::all_of(token.begin(), token.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
  return token.empty() || !is_plain ? std::string() : "token=" + std::string(token);
}

std::string WithToken(std::string_view base_url, std::string_view path, std::string_view token) {
  if (token.empty()) return fmt::format("{}{}", base_url, path);
  return fmt::format("{}{}{}{}", base_url, path, path.find('?') == std::string_view::npos ? '?' : '&', token);
}

std::string LinkTo(const Request& request, std::string_view path) {
  return WithToken(request.base_url, path, TokenInQuery(request));
}

std::string PercentEncoded(std::string_view text, std::string_view plain) {
  std::string encoded;
  for (const char c : text) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                          plain.find(c) != std::string_view::npos;
    encoded += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return encoded;
}

std::string EncodedForQuery(std::string_view text) { return PercentEncoded(text, "-._~,:"); }

}  // namespace skyquilt::api
