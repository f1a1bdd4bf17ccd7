// SignRequest: the Authorization of a request to S3, by AWS Signature Version 4. Pure; any thread. The secret
// key appears in nothing that comes out. Source: AWS General Reference, "Signature Version 4 signing
// process"; Amazon S3 API Reference, "Authenticating Requests".
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skyquilt::storage {

struct S3Credentials {
  std::string access_key;
  std::string secret_key;
  std::string session_token;                      // of a role; empty for keys that last
  std::chrono::system_clock::time_point expires;  // zero: never
};

using NamedValues = std::vector<std::pair<std::string, std::string>>;

struct RequestToSign {
  std::string method;
  std::string host;     // with its port where that is not the usual one
  std::string path;     // "/bucket/key", not encoded
  NamedValues query;    // not encoded; a value may be empty ("?uploads")
  NamedValues headers;  // beyond Host and those that signing adds
  std::string payload_sha256;
};

inline constexpr const char* kEmptySha256 =
    "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

// RFC 3986 as S3 wants it: letters, digits, "-", ".", "_" and "~" stay; a slash where it separates folders.
std::string UriEncode(std::string_view text, bool keeps_slashes);
// "a=1&b=": encoded and in the order of names.
std::string EncodedQuery(NamedValues query);

// The headers to send, those given included, without Host.
NamedValues SignRequest(const RequestToSign& request, const S3Credentials& credentials,
                        const std::string& region, std::chrono::system_clock::time_point now);

}  // namespace skyquilt::storage
