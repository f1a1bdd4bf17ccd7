// ReadRequestHead: checks that the HTTP library omits (Boost 1.74 accepts no Host, two Hosts, unknown
// transfer codings, folded headers and 8-bit targets): the raw header block is checked against RFC 9112
// before it is used. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "core/base/result.h"

namespace skyquilt::server {

// Why a request is refused, as a status and a sentence.
struct Refusal {
  int status = 400;
  std::string reason;
};

// The raw bytes from the request line to before the empty line: no folding, no 8-bit or control characters in
// the request line, lines ended by CR LF.
std::optional<Refusal> CheckRawHead(std::string_view raw);

// What the rest of the server goes by.
struct RequestHead {
  std::string method;  // as sent
  std::string target;  // origin form
  int version = 11;    // 10 or 11
  api::Headers headers;
  std::string host;
  bool is_chunked = false;
  std::optional<std::uint64_t> content_length;
  bool wants_continue = false;
};

// Framing and host rules over the parsed fields. Fills host, is_chunked, content_length, wants_continue, and
// turns an absolute-form target into origin form.
std::optional<Refusal> CheckFields(RequestHead& head);

}  // namespace skyquilt::server
