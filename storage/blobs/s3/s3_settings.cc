#include "storage/blobs/s3/s3_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "core/base/text/plain_text.h"

namespace skyquilt::storage {
namespace {

constexpr std::string_view kScheme = "s3://";

bool IsBucketName(const std::string& name) {
  const auto is_plain = [](unsigned char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '_';
  };
  return name.size() >= 3 && name.size() <= 63 && std::all_of(name.begin(), name.end(), is_plain) &&
         std::isalnum(static_cast<unsigned char>(name.front())) != 0;
}

bool IsPrefix(const std::string& prefix) {
  return prefix.size() <= 512 && prefix.find("//") == std::string::npos && !prefix.starts_with('/') &&
         ("/" + prefix).find("/../") == std::string::npos &&
         ("/" + prefix).find("/./") == std::string::npos &&
         std::all_of(prefix.begin(), prefix.end(), [](unsigned char c) { return c > 0x20 && c < 0x7f; });
}

bool IsNo(std::string_view value) {
  const std::string text = LowerCase(value);
  return text == "no" || text == "false" || text == "off" || text == "0";
}

std::string FirstOf(const Variable& variable, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (std::string value = variable(name); !value.empty()) return value;
  }
  return "";
}

// "https://host:port/" to its parts. A path behind it is none that S3 has.
Result<void> TakeEndpoint(std::string text, const std::string& usual_scheme, S3Settings& settings) {
  const Error bad{ErrorCode::kInvalidArgument,
                  fmt::format("The endpoint \"{}\" of S3 is none: set AWS_ENDPOINT_URL to an address such as "
                              "https://s3.example.org:9000.",
                              text),
                  ""};
  settings.scheme = usual_scheme;
  if (const std::size_t end = text.find("://"); end != std::string::npos) {
    settings.scheme = text.substr(0, end);
    text.erase(0, end + 3);
  }
  while (text.ends_with('/')) text.pop_back();
  const bool is_plain = std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '-' || c == ':' || c == '[' || c == ']';
  });
  if (text.empty() || !is_plain || (settings.scheme != "http" && settings.scheme != "https")) return bad;
  settings.host = text;
  return {};
}

}  // namespace

std::string EnvironmentVariable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::string S3Settings::PathOf(const std::string& key) const {
  const std::string object = key.empty() ? "" : prefix + key;
  return is_bucket_in_host ? "/" + object : "/" + bucket + (object.empty() ? "" : "/" + object);
}

Result<S3Settings> ReadS3Settings(const std::string& address, const Variable& variable) {
  S3Settings settings;
  const std::string rest = address.starts_with(kScheme) ? address.substr(kScheme.size()) : "";
  settings.bucket = rest.substr(0, rest.find('/'));
  if (const std::size_t slash = rest.find('/'); slash != std::string::npos)
    settings.prefix = rest.substr(slash + 1);
  if (!settings.prefix.empty() && !settings.prefix.ends_with('/')) settings.prefix += '/';
  if (!IsBucketName(settings.bucket) || !IsPrefix(settings.prefix)) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("\"{}\" is no place in S3: give it as s3://bucket/prefix, in plain letters.", address),
        ""};
  }
  if (std::string region = FirstOf(variable, {"AWS_REGION", "AWS_DEFAULT_REGION"}); !region.empty())
    settings.region = std::move(region);
  const std::string url = FirstOf(variable, {"AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL"});
  const std::string host = variable("AWS_S3_ENDPOINT");
  const bool is_own = !url.empty() || !host.empty();
  if (!is_own) settings.host = fmt::format("s3.{}.amazonaws.com", settings.region);
  if (is_own) {
    if (auto taken =
            TakeEndpoint(url.empty() ? host : url, IsNo(variable("AWS_HTTPS")) ? "http" : "https", settings);
        !taken) {
      return taken.error();
    }
  }
  const std::string virtual_hosting = variable("AWS_VIRTUAL_HOSTING");
  // A bucket with a dot in its name is no host that a certificate could be for.
  settings.is_bucket_in_host = virtual_hosting.empty()
                                   ? !is_own && settings.bucket.find('.') == std::string::npos
                                   : !IsNo(virtual_hosting);
  return settings;
}

}  // namespace skyquilt::storage
