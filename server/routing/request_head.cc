#include "server/routing/request_head.h"

#include <boost/beast/http/buffer_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <utility>

#include "core/base/text/plain_text.h"
#include "server/routing/public_address.h"

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
    head.content_length = ParseNumber<std::uint64_t>(*length);
    if (!head.content_length) return BadRequest("Content-Length is not a number.");
  }
  const std::optional<std::string> expect = OnlyValue(head.headers, "Expect", &count);
  if (expect) {
    if (!api::EqualsIgnoringCase(*expect, "100-continue"))
      return Refusal{417, "Only 100-continue can be expected."};
    head.wants_continue = head.version >= 11;
  }
  return std::nullopt;
}

namespace http = boost::beast::http;

constexpr std::string_view kEndOfHead = "\r\n\r\n";
constexpr const char* kTooLong = "The request head is longer than the server reads.";

// The raw bytes from the request line to before the empty line, against RFC 9112: no folding, no 8-bit or
// control characters in the request line, lines ended by CR LF.
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

// Framing and host rules over the parsed fields. Fills host, is_chunked, content_length, wants_continue, and
// turns an absolute-form target into origin form.
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

}  // namespace

HeadParser::HeadParser(const HttpSettings& settings) : settings_(settings) {}
HeadParser::~HeadParser() = default;

std::unique_ptr<RequestParser> HeadParser::TakeParser() { return std::move(parser_); }

HeadState HeadParser::Examine(std::string_view bytes) {
  const std::size_t end = bytes.find(kEndOfHead, searched_);
  if (end != std::string_view::npos) return Parse(bytes.substr(0, end + kEndOfHead.size()));
  if (const auto refusal = CheckRawHead(bytes)) return Refuse(*refusal);
  if (bytes.size() >= settings_.max_header_bytes) return Refuse({431, kTooLong});
  searched_ = bytes.size() < kEndOfHead.size() ? 0 : bytes.size() - kEndOfHead.size() + 1;
  return HeadState::kNeedsMore;
}

HeadState HeadParser::Parse(std::string_view head_with_end) {
  const std::string_view raw = head_with_end.substr(0, head_with_end.size() - kEndOfHead.size());
  if (raw.size() > settings_.max_header_bytes) return Refuse({431, kTooLong});
  if (const auto refusal = CheckRawHead(raw)) return Refuse(*refusal);
  parser_ = std::make_unique<RequestParser>();
  parser_->header_limit(static_cast<std::uint32_t>(settings_.max_header_bytes + kEndOfHead.size()));
  parser_->body_limit(settings_.max_body_bytes);
  boost::system::error_code error;
  size_ = parser_->put(boost::asio::buffer(head_with_end.data(), head_with_end.size()), error);
  if (error == http::error::body_limit) return Refuse({413, "The body is larger than the server takes."});
  if (error == http::error::bad_version) return Refuse({505, "Only HTTP/1.0 and HTTP/1.1 are spoken here."});
  if (error) return Refuse({400, "The request head is not HTTP: " + error.message() + "."});
  const auto& message = parser_->get();
  head_.method = std::string(message.method_string());
  head_.target = std::string(message.target());
  head_.version = static_cast<int>(message.version());
  for (const auto& field : message) {
    head_.headers.Add(std::string(field.name_string()), std::string(field.value()));
  }
  if (const auto refusal = CheckFields(head_)) return Refuse(*refusal);
  return HeadState::kWhole;
}

HeadState HeadParser::Refuse(Refusal refusal) {
  refusal_ = std::move(refusal);
  return HeadState::kRefused;
}

}  // namespace skyquilt::server
