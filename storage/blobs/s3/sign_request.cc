#include "storage/blobs/s3/sign_request.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/base/text/percent.h"
#include "storage/blobs/sha256.h"

namespace skyquilt::storage {
namespace {

constexpr const char* kAlgorithm = "AWS4-HMAC-SHA256";

// "20130524T000000Z"
std::string StampOf(std::chrono::system_clock::time_point now) {
  return fmt::format("{:%Y%m%dT%H%M%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(now)));
}

std::string ScopeOf(const std::string& stamp, const std::string& region) {
  return fmt::format("{}/{}/s3/aws4_request", stamp.substr(0, 8), region);
}

// Names in lower case, in their order.
std::map<std::string, std::string> CanonicalHeaders(const NamedValues& headers, const std::string& host) {
  std::map<std::string, std::string> canonical = {{"host", host}};
  for (const auto& [name, value] : headers) canonical[LowerCase(name)] = Trim(value);
  return canonical;
}

std::string NamesOf(const std::map<std::string, std::string>& headers) {
  std::string names;
  for (const auto& [name, value] : headers) names += (names.empty() ? "" : ";") + name;
  return names;
}

std::string SignatureOf(const RequestToSign& request, const std::map<std::string, std::string>& headers,
                        const S3Credentials& credentials, const std::string& region,
                        const std::string& stamp) {
  std::string canonical =
      fmt::format("{}\n{}\n{}\n", request.method, UriEncode(request.path, true), EncodedQuery(request.query));
  for (const auto& [name, value] : headers) canonical += fmt::format("{}:{}\n", name, value);
  canonical += fmt::format("\n{}\n{}", NamesOf(headers), request.payload_sha256);
  const std::string to_sign =
      fmt::format("{}\n{}\n{}\n{}", kAlgorithm, stamp, ScopeOf(stamp, region), Sha256Hex(canonical));
  std::string key = HmacSha256("AWS4" + credentials.secret_key, stamp.substr(0, 8));
  for (const std::string_view part : {std::string_view(region), std::string_view("s3"),
                                      std::string_view("aws4_request"), std::string_view(to_sign)}) {
    key = HmacSha256(key, part);
  }
  return HexOf(key);
}

}  // namespace

std::string UriEncode(std::string_view text, bool keeps_slashes) {
  return PercentEncoded(text, keeps_slashes ? "-._~/" : "-._~");
}

std::string EncodedQuery(NamedValues query) {
  for (auto& [name, value] : query) {
    name = UriEncode(name, false);
    value = UriEncode(value, false);
  }
  std::sort(query.begin(), query.end());
  std::string text;
  for (const auto& [name, value] : query)
    text += fmt::format("{}{}={}", text.empty() ? "" : "&", name, value);
  return text;
}

NamedValues SignRequest(const RequestToSign& request, const S3Credentials& credentials,
                        const std::string& region, std::chrono::system_clock::time_point now) {
  const std::string stamp = StampOf(now);
  NamedValues headers = request.headers;
  headers.emplace_back("x-amz-content-sha256", request.payload_sha256);
  headers.emplace_back("x-amz-date", stamp);
  if (!credentials.session_token.empty())
    headers.emplace_back("x-amz-security-token", credentials.session_token);
  const auto canonical = CanonicalHeaders(headers, request.host);
  const std::string signature = SignatureOf(request, canonical, credentials, region, stamp);
  headers.emplace_back("Authorization", fmt::format("{} Credential={}/{},SignedHeaders={},Signature={}",
                                                    kAlgorithm, credentials.access_key,
                                                    ScopeOf(stamp, region), NamesOf(canonical), signature));
  return headers;
}

}  // namespace skyquilt::storage
