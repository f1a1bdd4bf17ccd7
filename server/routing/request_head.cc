#include "server/routing/request_head.h"

#include <charconv>

#include "server/routing/host_name.h"

namespace skyquilt::server {
namespace {

Refusal BadRequest(const char* reason) { return {400, reason}; }

std::optional<std::string> OnlyValue(const api::Headers& headers, std::string_view name, int* count) {
  std::optional<std::string> value;
  *count = 0;
  for (const auto& [known, text] : headers.list()) {
    if (!api::EqualsIgnoringCase(known, name)) continue;
    ++*count;
    value = text;
  }
  return value;
}

std::optional<Refusal> CheckTarget(RequestHead& head) {
  if (head.target.size() > 8192) return Refusal{414, "The request target is too long."};
  // Proxies send the absolute form; its host is what Host must say anyway.
  constexpr std::string_view kScheme = "http://";
  if (head.target.size() > kScheme.size() &&
      api::EqualsIgnoringCase(head.target.substr(0, kScheme.size()), kScheme)) {
    const std::size_t path = head.target.find_first_of("/?", kScheme.size());
    const std::string authority = head.target.substr(kScheme.size(), path - kScheme.size());
    if (!api::EqualsIgnoringCase(authority, head.host)) return BadRequest("The target and the Host differ.");
    std::string origin_form = path == std::string::npos ? "/" : head.target.substr(path);
    if (origin_form.front() == '?') origin_form.insert(0, 1, '/');
    head.target = std::move(origin_form);
  }
  if (head.target == "*" && head.method == "OPTIONS") return std::nullopt;
  if (head.target.empty() || head.target.front() != '/')
    return BadRequest("The request target is not a path.");
  return std::nullopt;
}

std::optional<Refusal> CheckFraming(RequestHead& head) {
  int count = 0;
  const std::optional<std::string> coding = OnlyValue(head.headers, "Transfer-Encoding", &count);
  if (coding) {
    if (count != 1 || !api::EqualsIgnoringCase(*coding, "chunked")) {
      return Refusal{501, "The only transfer coding known here is chunked."};
    }
    if (head.version < 11) return BadRequest("HTTP/1.0 knows no transfer coding.");
    head.is_chunked = true;
  }
  const std::optional<std::string> length = OnlyValue(head.headers, "Content-Length", &count);
  if (length) {
    if (count != 1) return BadRequest("Content-Length comes more than once.");
    if (head.is_chunked) return BadRequest("Content-Length and Transfer-Encoding come together.");
    std::uint64_t value = 0;
    const auto parsed = std::from_chars(length->data(), length->data() + length->size(), value);
    if (length->empty() || parsed.ec != std::errc() || parsed.ptr != length->data() + length->size()) {
      return BadRequest("Content-Length is not a number.");
    }
    head.content_length = value;
  }
  const std::optional<std::string> expect = OnlyValue(head.headers, "Expect", &count);
  if (expect) {
    if (!api::EqualsIgnoringCase(*expect, "100-continue"))
      return Refusal{417, "Only 100-continue can be expected."};
    head.wants_continue = head.version >= 11;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Refusal> CheckRawHead(std::string_view raw) {
  const std::size_t end = raw.find("\r\n");
  std::string_view line = raw.substr(0, end);
  // The other half of the line end is still on its way.
  if (end == std::string_view::npos && line.ends_with('\r')) line.remove_suffix(1);
  for (const char c : line) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x80) return BadRequest("The request line has bytes that are not ASCII.");
    if (byte < 0x20 || byte == 0x7f) return BadRequest("The request line has a control character.");
  }
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const char c = raw[i];
    if (c == '\n' && (i == 0 || raw[i - 1] != '\r')) return BadRequest("A header line ends without CR.");
    if (c == '\n' && i + 1 < raw.size() && (raw[i + 1] == ' ' || raw[i + 1] == '\t')) {
      return BadRequest("A header is folded over two lines.");
    }
    if (c == '\0') return BadRequest("A header has a NUL character.");
  }
  return std::nullopt;
}

std::optional<Refusal> CheckFields(RequestHead& head) {
  int count = 0;
  const std::optional<std::string> host = OnlyValue(head.headers, "Host", &count);
  if (count > 1) return BadRequest("Host comes more than once.");
  if (count == 0 && head.version >= 11) return BadRequest("Host is missing.");
  head.host = host.value_or("");
  if (count == 1 && !NameOfHost(head.host)) return BadRequest("Host is not a host.");
  if (auto refusal = CheckTarget(head)) return refusal;
  return CheckFraming(head);
}

}  // namespace skyquilt::server
