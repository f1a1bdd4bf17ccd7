#include "api/http/links.h"

#include <fmt/format.h>

#include <algorithm>

#include "api/http/parameters.h"
#include "core/base/text/percent.h"

namespace skyquilt::api {

std::string TokenInQuery(const Request& request) {
  const std::string token = Parameter(request, "token").value_or("");
  const bool is_plain = std::all_of(token.begin(), token.end(),
                                    [](char c) { return IsLetterOrDigit(c) || c == '-' || c == '_'; });
  return token.empty() || !is_plain ? std::string() : "token=" + token;
}

std::string WithToken(std::string_view base_url, std::string_view path, std::string_view token) {
  if (token.empty()) return fmt::format("{}{}", base_url, path);
  return fmt::format("{}{}{}{}", base_url, path, path.find('?') == std::string_view::npos ? '?' : '&', token);
}

std::string LinkTo(const Request& request, std::string_view path) {
  return WithToken(request.base_url, path, TokenInQuery(request));
}

std::string EncodedForQuery(std::string_view text) { return PercentEncoded(text, "-._~,:"); }

}  // namespace skyquilt::api
