#include "server/routing/origin_policy.h"

#include <algorithm>

namespace skyquilt::server {
namespace {

// Of a request and of an answer, by the routes there are.
constexpr const char* kMaySend =
    "Authorization, Content-Type, Content-Digest, Idempotency-Key, If-Match, If-None-Match, If-Range, Last-Event-ID, "
    "Prefer, Range, Tus-Resumable, Upload-Checksum, Upload-Concat, Upload-Defer-Length, Upload-Length, Upload-Metadata, Upload-Offset, "
    "X-HTTP-Method-Override, set-uuid";
constexpr const char* kMayRead =
    "Accept-Ranges, Content-Bbox, Content-Crs, Content-Disposition, Content-Length, Content-Range, ETag, "
    "Idempotency-Replayed, Link, Location, "
    "Preference-Applied, Retry-After, Tus-Checksum-Algorithm, Tus-Extension, Tus-Max-Size, Tus-Resumable, Tus-Version, Upload-Defer-Length, "
    "Upload-Expires, Upload-Length, Upload-Metadata, Upload-Offset, WWW-Authenticate, X-Request-Id";

// What pages of this server have as their origin.
std::string OwnOrigin(const RequestHead& head, const HttpSettings& settings) {
  if (!settings.public_url.empty()) {
    const std::size_t host = settings.public_url.find("://") + 3;
    return settings.public_url.substr(0, settings.public_url.find('/', host));
  }
  // A proxy that speaks TLS for us says so; a page cannot make a browser say it.
  const bool is_tls = api::EqualsIgnoringCase(head.headers.Find("X-Forwarded-Proto"), "https");
  return (is_tls ? "https://" : "http://") + head.host;
}

}  // namespace

bool IsFromForeignPage(const RequestHead& head, const HttpSettings& settings) {
  const std::string_view site = head.headers.Find("Sec-Fetch-Site");
  if (!site.empty()) return site != "same-origin" && site != "none";
  const std::string_view origin = head.headers.Find("Origin");
  return !origin.empty() && !api::EqualsIgnoringCase(origin, OwnOrigin(head, settings));
}

bool IsOriginAllowed(std::string_view origin, const HttpSettings& settings, bool requires_token) {
  if (settings.cors_origins.empty()) return requires_token;
  return std::any_of(settings.cors_origins.begin(), settings.cors_origins.end(),
                     [&](const std::string& known) { return api::EqualsIgnoringCase(known, origin); });
}

api::Headers CorsHeaders(const RequestHead& head, const HttpSettings& settings, bool requires_token) {
  api::Headers cors;
  const std::string_view origin = head.headers.Find("Origin");
  const bool is_any = settings.cors_origins.empty();
  if (!is_any) cors.Add("Vary", "Origin");
  // Where any page may read, all get the same header, so that caches need not distinguish them.
  if (is_any ? !requires_token : origin.empty() || !IsOriginAllowed(origin, settings, requires_token))
    return cors;
  cors.Add("Access-Control-Allow-Origin", is_any ? "*" : std::string(origin));
  cors.Add("Access-Control-Expose-Headers", kMayRead);
  return cors;
}

void AddPreflightHeaders(const std::string& allow, api::Headers& cors) {
  if (!cors.Has("Access-Control-Allow-Origin")) return;
  cors.Add("Access-Control-Allow-Methods", allow);
  cors.Add("Access-Control-Allow-Headers", kMaySend);
  cors.Add("Access-Control-Max-Age", "86400");
}

bool IsOriginText(std::string_view text) {
  const std::string_view scheme = text.starts_with("http://") ? "http://" : "https://";
  if (!text.starts_with(scheme)) return false;
  const std::string_view rest = text.substr(scheme.size());
  return !rest.empty() && rest.find_first_of("/?#@ ,\"<>*") == std::string_view::npos;
}

}  // namespace skyquilt::server
