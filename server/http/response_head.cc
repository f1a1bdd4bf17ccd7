#include "server/http/response_head.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <iterator>

#include "api/http/responses.h"

namespace skyquilt::server {
namespace {

// Formatted once a second and thread.
const std::string& DateNow() {
  thread_local std::time_t made_at = 0;
  thread_local std::string date;
  const std::time_t now = std::time(nullptr);
  if (now != made_at) {
    date = fmt::format("{:%a, %d %b %Y %H:%M:%S} GMT", fmt::gmtime(now));
    made_at = now;
  }
  return date;
}

}  // namespace

std::string ResponseHead(const api::Response& response, std::optional<std::uint64_t> content_length,
                         bool keep_alive, std::string_view request_id) {
  std::string head;
  head.reserve(512);
  const auto out = std::back_inserter(head);
  fmt::format_to(out, "HTTP/1.1 {} {}\r\nDate: {}\r\nX-Request-Id: {}\r\n", response.status,
                 api::ReasonOf(response.status), DateNow(), request_id);
  for (const auto& [name, value] : response.headers.list()) {
    head += name;
    head += ": ";
    head += value;
    head += "\r\n";
  }
  head += "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n";
  if (content_length) fmt::format_to(out, "Content-Length: {}\r\n", *content_length);
  head += keep_alive ? "\r\n" : "Connection: close\r\n\r\n";
  return head;
}

}  // namespace skyquilt::server
